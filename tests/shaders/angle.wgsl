// A point on the circle after so many turns; sine and 1 - cosine of an angle, and the angle of a point.
struct In {
    turns: f32,
    angle: f32,
    point: vec2<f32>,
}

struct Out {
    on_circle: vec2<f32>,
    sine_and_rise: vec2<f32>,
    angle: f32,
    padding: f32,
}

fn run(row: u32) {
    let given = input[row];
    output[row] = Out(circle_point(given.turns), sine_and_rise(given.angle), angle_of(given.point.y, given.point.x), 0.0);
}

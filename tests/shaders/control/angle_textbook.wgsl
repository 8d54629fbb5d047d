// The driver's functions, of angles of several turns, and differences from 1 and of angles.
fn angle_of(y: f32, x: f32) -> f32 {
    return acos(x / length(vec2<f32>(x, y)));
}

fn circle_point(turns: f32) -> vec2<f32> {
    let angle = 6.28318531 * turns;
    return vec2<f32>(cos(angle), sin(angle));
}

fn sine_and_rise(angle: f32) -> vec2<f32> {
    return vec2<f32>(sin(angle), 1.0 - cos(angle));
}

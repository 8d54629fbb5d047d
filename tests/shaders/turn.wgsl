//@ use texture/marble
// An angle minus a multiple of 2 pi, and its sine.
struct Out {
    angle: f32,
    sine: f32,
}

alias In = f32;

fn run(row: u32) {
    let angle = within_one_turn(input[row]);
    output[row] = Out(angle, circle_point(angle * 0.15915494).y);
}

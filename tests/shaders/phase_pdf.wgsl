//@ use medium/phase_pdf
// The density of a direction after scattering.
struct In {
    incoming: vec3<f32>,
    g: f32,
    direction: vec3<f32>,
    one_minus_g: f32,
}

alias Out = f32;

fn run(row: u32) {
    let given = input[row];
    output[row] = phase_pdf(given.incoming, given.direction, given.g, given.one_minus_g);
}

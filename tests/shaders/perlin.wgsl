struct In {
    point: vec3<f32>,
    padding: u32,
}

struct Out {
    noise: f32,
    turbulence: f32,
}

fn run(row: u32) {
    output[row] = Out(perlin(input[row].point), turbulence(input[row].point));
}

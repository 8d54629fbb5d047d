struct In {
    point: vec3<f32>,
    padding: u32,
}

struct Out {
    noise: f32,
    turbulence: f32,
}

@group(0) @binding(21) var<storage, read> input: array<In>;
@group(0) @binding(22) var<storage, read_write> output: array<Out>;

fn run(row: u32) {
    output[row] = Out(perlin(input[row].point), turbulence(input[row].point));
}

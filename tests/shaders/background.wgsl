//@ use background/${kind}
struct In {
    direction: vec3<f32>,
    padding: u32,
}

struct Out {
    radiance: vec3<f32>,
    padding: u32,
}

@group(0) @binding(21) var<storage, read> input: array<In>;
@group(0) @binding(22) var<storage, read_write> output: array<Out>;

fn run(row: u32) {
    output[row] = Out(${kind}_background(input[row].direction), 0u);
}

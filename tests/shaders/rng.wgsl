//@ use sampler/independent
struct Out {
    bits: vec4<u32>,
    // The uniforms of the key (pixel, sample, dimension, seed).
    u: vec4<f32>,
    // The key itself taken for random bits.
    direct: vec4<f32>,
}

@group(0) @binding(21) var<storage, read> input: array<vec4<u32>>;
@group(0) @binding(22) var<storage, read_write> output: array<Out>;

fn run(row: u32) {
    let key = input[row];
    output[row] = Out(pcg4d(key), random4(key.x, key.y, key.z, key.w), unit_interval(key));
}

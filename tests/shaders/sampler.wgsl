//@ use choice/sampler
// A sampler's numbers by their key: pixel, sample, dimension, seed.
struct Out {
    words: vec4<u32>,
    u: vec4<f32>,
}

@group(0) @binding(21) var<storage, read> input: array<vec4<u32>>;
@group(0) @binding(22) var<storage, read_write> output: array<Out>;

fn run(row: u32) {
    let key = input[row];
    output[row] = Out(random_words(key.x, key.y, key.z, key.w), random4(key.x, key.y, key.z, key.w));
}

//@ use choice/sampler
// A sampler's numbers by their key: pixel, sample, dimension, seed.
struct Out {
    words: vec4<u32>,
    u: vec4<f32>,
}

alias In = vec4<u32>;

fn run(row: u32) {
    let key = input[row];
    output[row] = Out(random_words(key.x, key.y, key.z, key.w), random4(key.x, key.y, key.z, key.w));
}

//@ use sampler/independent
struct Out {
    bits: vec4<u32>,
    // The uniforms of the key (pixel, sample, dimension, seed).
    u: vec4<f32>,
    // The key itself taken for random bits.
    direct: vec4<f32>,
}

alias In = vec4<u32>;

fn run(row: u32) {
    let key = input[row];
    output[row] = Out(pcg4d(key), random4(key.x, key.y, key.z, key.w), unit_interval(key));
}

// Wrong on purpose: a step of a linear congruential generator without the mixing, and all 32 bits rounded to a float.
fn pcg4d(key: vec4<u32>) -> vec4<u32> {
    return (key + key.yzwx * 3u) * 1664525u + 1013904223u;
}

fn unit_interval(bits: vec4<u32>) -> vec4<f32> {
    return vec4<f32>(bits) * 0x1p-32f;
}

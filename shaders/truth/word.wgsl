// Words of values. 0 stands for no value, so that a value of 0 has the bits of -0.
fn word_of(value: f32) -> u32 {
    let bits = bitcast<u32>(value);
    return select(bits, 0x80000000u, bits == 0u);
}

fn words_of(values: vec3<f32>) -> vec3<u32> {
    return vec3<u32>(word_of(values.x), word_of(values.y), word_of(values.z));
}

// Whether a path's ray has hit a surface.
fn has_hit(path: ptr<function, Path>) -> bool {
    return (*path).status < FIRST_STATUS;
}

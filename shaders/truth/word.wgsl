// Words of values. 0 stands for no value, so that a value of 0 has the bits of -0.
fn words_of(values: vec3<f32>) -> vec3<u32> {
    let bits = bitcast<vec3<u32>>(values);
    return select(bits, vec3<u32>(0x80000000u), bits == vec3<u32>(0u));
}

// Whether a path's ray has hit a surface.
fn has_hit(path: ptr<function, Path>) -> bool {
    return (*path).status < FIRST_STATUS;
}

// A unit vector in one word: the octahedron |x| + |y| + |z| = 1 unfolded to a square, stored as two signed 16-bit numbers
// (Cigolle et al., "A Survey of Efficient Representations for Independent Unit Vectors", JCGT 3(2), 2014, section 3.2).
fn unit_from_octahedral(word: u32) -> vec3<f32> {
    let p = unpack2x16snorm(word);
    let z = 1.0 - abs(p.x) - abs(p.y);
    let folded = (vec2<f32>(1.0) - abs(p.yx)) * select(vec2<f32>(-1.0), vec2<f32>(1.0), p >= vec2<f32>(0.0));
    return normalize(vec3<f32>(select(p, folded, z < 0.0), z));
}

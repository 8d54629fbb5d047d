// The equal-area octahedral map of Clarberg ("Fast Equal-Area Mapping of the (Hemi)Sphere using SIMD", Journal of Graphics Tools 13(3), 2008), as
// pbrt-v4 has it: where a unit direction lies on the square, both in [0, 1]. +z is in the middle, +x at the right, +y below, -z in the corners.
fn square_map(d: vec3<f32>) -> vec2<f32> {
    // sqrt(1 - |z|), which would cancel near the middle.
    let r = length(d.xy) / sqrt(1.0 + abs(d.z));
    let share = angle_of(abs(d.y), abs(d.x)) * 0.63661977;
    let upper = vec2<f32>(r - r * share, r * share);
    let p = select(upper, vec2<f32>(1.0) - upper.yx, d.z < 0.0);
    let signed = select(p, -p, d.xy < vec2<f32>(0.0));
    return clamp(vec2<f32>(0.5) + 0.5 * signed, vec2<f32>(0.0), vec2<f32>(1.0));
}

// Wrong here: 256 ulps along the normal (Wächter and Binder, "A Fast and Robust Method for Avoiding Self-Intersection",
// Ray Tracing Gems, ch. 6), which does not know how small the primitive is.
fn leave_surface(point: vec3<f32>, error: f32, normal: vec3<f32>, direction: vec3<f32>) -> vec3<f32> {
    let outward = select(-normal, normal, dot(direction, normal) >= 0.0);
    let steps = vec3<i32>(256.0 * outward);
    let moved = bitcast<vec3<f32>>(bitcast<vec3<i32>>(point) + select(steps, -steps, point < vec3<f32>(0.0)));
    return select(moved, point + outward / 65536.0, abs(point) < vec3<f32>(1.0 / 32.0));
}

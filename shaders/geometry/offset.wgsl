// The origin of a ray that leaves a surface. The point moves along the normal, to the side that the ray goes to, by the bound
// of its error. Then each coordinate moves to the next float, so that rounding cannot undo the move (PBR 4th ed., section
// 6.8.6, with the primitive's own bound).
fn leave_surface(point: vec3<f32>, error: f32, normal: vec3<f32>, direction: vec3<f32>) -> vec3<f32> {
    let outward = select(-normal, normal, dot(direction, normal) >= 0.0);
    let moved = point + error * outward;
    return vec3<f32>(
        next_float(moved.x, outward.x),
        next_float(moved.y, outward.y),
        next_float(moved.z, outward.z),
    );
}

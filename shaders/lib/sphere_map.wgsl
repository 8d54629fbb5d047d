// Directions as places on an image.

// The texture coordinates of a sphere at its unit normal n: u = (atan2(-z, x) + pi) / 2 pi, v = acos(-y) / pi.
// v by atan2, which keeps its digits at the poles.
fn sphere_uv_at(n: vec3<f32>) -> vec2<f32> {
    let u = (atan2(-n.z, n.x) + 3.14159265) * 0.15915494;
    let v = atan2(length(n.xz), -n.y) * 0.31830989;
    return clamp(vec2<f32>(u, v), vec2<f32>(0.0), vec2<f32>(1.0));
}

// A latitude-longitude image of the sky: u and the way down from the top row, for a unit direction; +y on top, -z in the
// middle, +x on the right half.
fn sky_place(direction: vec3<f32>) -> vec2<f32> {
    let u = 0.5 + atan2(direction.x, -direction.z) * 0.15915494;
    let down = atan2(length(direction.xz), direction.y) * 0.31830989;
    return clamp(vec2<f32>(u, down), vec2<f32>(0.0), vec2<f32>(1.0));
}

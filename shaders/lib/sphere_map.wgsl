// Maps from directions to texture coordinates.

// The texture coordinates of a sphere at its unit normal n: u = (atan2(-z, x) + pi) / 2 pi, v = acos(-y) / pi.
fn sphere_uv_at(n: vec3<f32>) -> vec2<f32> {
    let u = 0.5 + turns_around(-n.z, n.x);
    let v = angle_of(length(n.xz), -n.y) * 0.31830989;
    return clamp(vec2<f32>(u, v), vec2<f32>(0.0), vec2<f32>(1.0));
}

// Texture coordinates of a unit direction in a latitude-longitude image of the sky: u, and the distance down from the top row, both in
// [0, 1]. +y is at the top, -z in the middle, and +x in the right half.
fn sky_uv(direction: vec3<f32>) -> vec2<f32> {
    let u = 0.5 + turns_around(direction.x, -direction.z);
    let down = angle_of(length(direction.xz), direction.y) * 0.31830989;
    return clamp(vec2<f32>(u, down), vec2<f32>(0.0), vec2<f32>(1.0));
}

// The angle from (1, 0) to (x, y) in turns, in [-1/2, 1/2].
fn turns_around(y: f32, x: f32) -> f32 {
    let turns = angle_of(abs(y), x) * 0.15915494;
    return select(turns, -turns, y < 0.0);
}

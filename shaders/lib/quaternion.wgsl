// Rotations as unit quaternions, the scalar last.

// The difference of a turned vector and the vector. It keeps its digits however small the angle is.
fn change_by_turn(q: vec4<f32>, v: vec3<f32>) -> vec3<f32> {
    let across = cross(q.xyz, v);
    return 2.0 * (q.w * across + cross(q.xyz, across));
}

fn apply_turn(q: vec4<f32>, v: vec3<f32>) -> vec3<f32> {
    return v + change_by_turn(q, v);
}

fn inverse_turn(q: vec4<f32>) -> vec4<f32> {
    return vec4<f32>(-q.xyz, q.w);
}

// First `inner`, then `outer`.
fn joined_turns(outer: vec4<f32>, inner: vec4<f32>) -> vec4<f32> {
    let vector = outer.w * inner.xyz + inner.w * outer.xyz + cross(outer.xyz, inner.xyz);
    return vec4<f32>(vector, outer.w * inner.w - dot(outer.xyz, inner.xyz));
}

// The quaternion on the way from one to another, whose dot product is not negative (Shoemake, "Animating Rotation with Quaternion Curves",
// SIGGRAPH 1985). Between near ones, the chord takes the place of the arc: at cos 0.9995, by 3e-7 of a turn.
fn turn_between(a: vec4<f32>, b: vec4<f32>, share: f32) -> vec4<f32> {
    let cosine = min(dot(a, b), 1.0);
    let chord = a + share * (b - a);
    let angle = acos(cosine);
    let arc = sin((1.0 - share) * angle) * a + sin(share * angle) * b;
    let way = select(arc, chord, cosine > 0.9995);
    return way * inverseSqrt(dot(way, way));
}

//@ implements close_signs when !siblings
// Signs of areas that are too close to 0 for floats, all at once.

// The signs of the three areas of areas_of(x, y): those that are certain, and the others exactly.
fn with_close_signs(signs: vec3<f32>, certain: vec3<bool>, x: vec3<f32>, y: vec3<f32>) -> vec3<f32> {
    let exact = vec3<f32>(close_sign(x.y, y.y, x.z, y.z), close_sign(x.z, y.z, x.x, y.x), close_sign(x.x, y.x, x.y, y.y));
    return select(exact, signs, certain);
}

//@ implements close_signs when siblings
// Signs of areas that are too close to 0 for floats, one after the other. They are rarely needed, but all at once they take more registers than all the
// rest of a walk.

// The signs of the three areas of areas_of(x, y): those that are certain, and the others exactly.
fn with_close_signs(signs: vec3<f32>, certain: vec3<bool>, x: vec3<f32>, y: vec3<f32>) -> vec3<f32> {
    var all = signs;
    if !certain.x {
        all.x = close_sign(x.y, y.y, x.z, y.z);
    }
    if !certain.y {
        all.y = close_sign(x.z, y.z, x.x, y.x);
    }
    if !certain.z {
        all.z = close_sign(x.x, y.x, x.y, y.y);
    }
    return all;
}

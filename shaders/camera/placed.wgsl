//@ implements lens_place when placed
//@ use bind/settings
// A camera that a page has moved: the settings say where it is in render space.
fn placed(point: vec3<f32>) -> vec3<f32> {
    return settings.camera_place + point;
}

//@ without
// The camera is at the origin of render space.
fn placed(point: vec3<f32>) -> vec3<f32> {
    return point;
}

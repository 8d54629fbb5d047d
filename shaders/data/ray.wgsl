// A ray: origin and unit direction, in render space (the camera at the origin, the scene's extent near 1).
struct Ray {
    origin: vec3<f32>,
    direction: vec3<f32>,
}

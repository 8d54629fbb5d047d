// A ray: origin and unit direction in render space, where the camera is at the origin and the scene's extent is near 1.
struct Ray {
    origin: vec3<f32>,
    direction: vec3<f32>,
}

// A ray and the distance at which it hits a surface.
struct RayToHit {
    ray: Ray,
    t: f32,
}

//@ use data/ray
// A path on its way, and the run that it is a sample of.
struct Path {
    ray: Ray,
    // Distance to the hit that `status` names.
    t: f32,
    // Code of the primitive that the ray hit, or what the path is doing (data/primitive).
    status: u32,
    // The share of the light met next that reaches the camera; of an ended path its radiance.
    throughput: vec3<f32>,
    // With a triangle's code: the instance that it is part of.
    instance: u32,
    // Scattering events so far.
    events: u32,
    pixel: u32,
    sample: u32,
    // As in RunRecord.
    counts: u32,
    // Radiance of the run's samples so far, and their rays.
    sum: vec3<f32>,
    rays: u32,
}

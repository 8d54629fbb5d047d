//@ use data/ray
// The first ray of a light path.
struct EmittedRay {
    ray: Ray,
    // Radiance times cosine over the density of the ray. 0 if there is no ray.
    weight: vec3<f32>,
    // That density over the cosine; 0 for a light without size.
    density: f32,
    // Whether the ray comes from infinity, where something may be in its way.
    is_parallel: bool,
}

fn no_emission() -> EmittedRay {
    return EmittedRay(Ray(vec3<f32>(0.0), vec3<f32>(0.0, 0.0, 1.0)), vec3<f32>(0.0), 0.0, false);
}

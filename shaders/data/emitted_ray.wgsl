// The first ray of a light path.
struct EmittedRay {
    ray: Ray,
    // Radiance times cosine over the density of the ray. 0 if there is no ray.
    weight: vec3<f32>,
    // That density over the cosine. For a light without size: in solid angle, or over the area across parallel rays.
    density: f32,
    // The radiance of the light along the ray; 1 for a light without size.
    radiance: vec3<f32>,
    // Whether the ray comes from infinity, where something may be in its way.
    is_parallel: bool,
}

fn no_emission() -> EmittedRay {
    return EmittedRay(Ray(vec3<f32>(0.0), vec3<f32>(0.0, 0.0, 1.0)), vec3<f32>(0.0), 0.0, vec3<f32>(0.0), false);
}

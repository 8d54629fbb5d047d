// Refraction at a smooth boundary between two clear solids.

struct Refraction {
    // The reflected fraction of unpolarised light.
    reflectance: f32,
    // Cosine between the transmitted ray and the inverted normal; 0 for total internal reflection.
    cos_transmitted: f32,
}

// The transmitted direction by Snell's law. The normal is on the side of the incoming ray.
fn refract_by(incoming: vec3<f32>, normal: vec3<f32>, cos_incident: f32, eta: f32, cos_transmitted: f32) -> vec3<f32> {
    return normalize(incoming / eta + (cos_incident / eta - cos_transmitted) * normal);
}

// A shading normal that faces away from the ray is bent back until the ray grazes it: a mirror would reflect the ray into the surface.
// Returns `otherwise` for one that points straight along the ray, or that has no direction.
fn bent_back(normal: vec3<f32>, incoming: vec3<f32>, otherwise: vec3<f32>) -> vec3<f32> {
    let bent = normal - max(dot(normal, incoming), 0.0) * incoming;
    if !(dot(bent, bent) > 1e-12) {
        return otherwise;
    }
    return normalize(bent);
}

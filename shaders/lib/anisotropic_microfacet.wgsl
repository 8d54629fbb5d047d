// The functions of lib/microfacet for microfacets with one alpha along the tangent and another along the bitangent (Heitz, "Understanding the
// Masking-Shadowing Function in Microfacet-Based BRDFs", JCGT 3(2), 2014, equations 85 to 87).

// |v|^4 / (pi a b (x^2/a^2 + y^2/b^2 + z^2)^2), with the alphas a and b.
fn anisotropic_density(along: vec3<f32>, alphas: vec2<f32>) -> f32 {
    let across = along.xy / alphas;
    let spread = dot(across, across) + along.z * along.z;
    if !(spread > 0.0) {
        return 0.0;
    }
    let ratio = dot(along, along) / spread;
    return ratio * ratio / (PI * alphas.x * alphas.y);
}

// The cosine times 1 + 2 Lambda.
fn anisotropic_root(direction: vec3<f32>, alphas: vec2<f32>) -> f32 {
    let across = alphas * direction.xy;
    return sqrt(direction.z * direction.z + dot(across, across));
}

fn sample_anisotropic_normal(view: vec3<f32>, alphas: vec2<f32>, u: vec2<f32>) -> vec3<f32> {
    let stretched = normalize(vec3<f32>(alphas * view.xy, view.z));
    let from_top = u.x * (1.0 + stretched.z);
    let across = sqrt(from_top * (2.0 - from_top)) * sample_circle(u.y) + stretched.xy;
    return normalize(vec3<f32>(alphas * across, (1.0 - u.x) * (1.0 + stretched.z)));
}

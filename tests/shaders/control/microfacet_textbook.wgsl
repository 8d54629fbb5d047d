// lib/microfacet with the density as papers write it, by 1 - cos^2.
const LEAST_ROUGHNESS: f32 = 0x1p-10f;

fn is_rough_boundary(alpha: f32, contrast: f32) -> bool {
    return alpha * min(abs(contrast), 1.0) >= LEAST_ROUGHNESS * LEAST_ROUGHNESS;
}

fn mirror_direction(incoming: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    return normalize(normalize(incoming - 2.0 * dot(incoming, normal) * normal));
}

fn width_of_reflection(alpha: f32) -> f32 {
    return 2.0 * alpha;
}

fn width_of_refraction(alpha: f32, eta: f32) -> f32 {
    return alpha * abs(1.0 - 1.0 / eta);
}

fn microfacet_density(along: vec3<f32>, normal: vec3<f32>, alpha: f32) -> f32 {
    let cosine = dot(normalize(along), normal);
    let tan2 = (1.0 - cosine * cosine) / (cosine * cosine);
    let root = alpha * cosine * cosine * (1.0 + tan2 / (alpha * alpha));
    return 1.0 / (PI * root * root);
}

fn smith_root(cosine: f32, alpha: f32) -> f32 {
    return sqrt(cosine * cosine + alpha * alpha * (1.0 - cosine) * (1.0 + cosine));
}

fn smith_shadowing(cos_view: f32, cos_light: f32, alpha: f32) -> f32 {
    // Without the heights' correlation.
    return 2.0 * cos_light / (cos_light + smith_root(cos_light, alpha));
}

fn visible_density(density: f32, cos_view: f32, alpha: f32) -> f32 {
    return 2.0 * density / (cos_view + smith_root(cos_view, alpha));
}

fn sample_visible_normal(view: vec3<f32>, alpha: f32, u: vec2<f32>) -> vec3<f32> {
    let stretched = normalize(vec3<f32>(alpha * view.xy, view.z));
    let from_top = u.x * (1.0 + stretched.z);
    let across = sqrt(from_top * (2.0 - from_top)) * sample_circle(u.y) + stretched.xy;
    return normalize(vec3<f32>(alpha * across, (1.0 - u.x) * (1.0 + stretched.z)));
}

// Wrong on purpose: the density as papers write it, by 1 - cos^2, and shadowing without the heights' correlation.
fn microfacet_density(along: vec3<f32>, normal: vec3<f32>, alpha: f32) -> f32 {
    let cosine = dot(normalize(along), normal);
    let tan2 = (1.0 - cosine * cosine) / (cosine * cosine);
    let root = alpha * cosine * cosine * (1.0 + tan2 / (alpha * alpha));
    return 1.0 / (PI * root * root);
}

fn smith_shadowing(cos_view: f32, cos_light: f32, alpha: f32) -> f32 {
    return 2.0 * cos_light / (cos_light + smith_root(cos_light, alpha));
}

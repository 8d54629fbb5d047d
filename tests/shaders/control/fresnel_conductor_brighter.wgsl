// lib/fresnel_conductor, 1 % brighter than Schlick's approximation.
fn schlick(cosine: f32, albedo: vec3<f32>) -> vec3<f32> {
    let m = 1.0 - cosine;
    let m2 = m * m;
    return 1.01 * (albedo + (1.0 - albedo) * (m2 * m2 * m));
}

fn reflectance_of_metal(cosine: f32, colour: vec3<f32>, k: vec3<f32>, has_index: bool) -> vec3<f32> {
    return schlick(cosine, colour);
}

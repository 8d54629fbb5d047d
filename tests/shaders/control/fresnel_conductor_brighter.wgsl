// Wrong on purpose: 1 % brighter than Schlick's approximation.
fn schlick(cosine: f32, albedo: vec3<f32>) -> vec3<f32> {
    return 1.01 * schlick_up_to(cosine, albedo, 1.0);
}

fn reflectance_of_metal(cosine: f32, colour: vec3<f32>, k: vec3<f32>, has_index: bool) -> vec3<f32> {
    return schlick(cosine, colour);
}

//@ use data/material
// No material of glTF has a thin film.
fn with_film(reflectance: vec3<f32>, f0: vec3<f32>, f90: f32, hit: Interaction, cosine: f32) -> vec3<f32> {
    return reflectance;
}

fn film_on_glass(under: Reflected, hit: Interaction, cosine: f32) -> Reflected {
    return under;
}

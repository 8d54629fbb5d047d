//@ use data/material
//@ use data/surface
// No material has energy compensation.
fn energy_compensation(material: Material, surface: Surface, hit: Interaction) -> f32 {
    return hit.compensation;
}

fn compensated(reflectance: vec3<f32>, f0: vec3<f32>, hit: Interaction) -> vec3<f32> {
    return reflectance;
}

//@ use data/material
//@ use data/surface
// No material makes up for what single scattering loses.
fn lost_over_kept(material: Material, surface: Surface, hit: Interaction) -> f32 {
    return hit.lost_over_kept;
}

fn with_lost_light(reflectance: vec3<f32>, straight: vec3<f32>, hit: Interaction) -> vec3<f32> {
    return reflectance;
}

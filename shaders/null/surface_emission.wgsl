//@ use data/material
//@ use data/path
// No surface emits and scatters.
fn radiance_of_surface(interaction: Interaction, bsdf: Scatter) -> vec3<f32> {
    return select(vec3<f32>(0.0), bsdf.weight, bsdf.event == EMITTED);
}

fn add_surface_emission(path: ptr<function, Path>, interaction: Interaction, bsdf: Scatter, weight: f32) {
}

//@ implements surface_emission when emission
//@ use choice/aov_direct
//@ use choice/light_groups
//@ use choice/clamp
// A surface that emits and scatters adds its emission, and the path goes on.

// The radiance that a surface emits, also where the path ends on it.
fn radiance_of_surface(interaction: Interaction, bsdf: Scatter) -> vec3<f32> {
    return select(interaction.emission, bsdf.weight, bsdf.event == EMITTED);
}

// `weight` is the MIS weight.
fn add_surface_emission(path: ptr<function, Path>, hit: Hit, interaction: Interaction, bsdf: Scatter, weight: f32) {
    let emission = select(interaction.emission, vec3<f32>(0.0), bsdf.event == EMITTED);
    let contribution = (*path).throughput * emission * weight;
    record_direct(path, contribution, (*path).depth);
    let limited = limited_indirect(contribution, (*path).depth);
    record_light(path, hit, limited);
    (*path).radiance += limited;
}

//@ without
// No surface emits and scatters.
fn radiance_of_surface(interaction: Interaction, bsdf: Scatter) -> vec3<f32> {
    return select(vec3<f32>(0.0), bsdf.weight, bsdf.event == EMITTED);
}

fn add_surface_emission(path: ptr<function, Path>, hit: Hit, interaction: Interaction, bsdf: Scatter, weight: f32) {
}

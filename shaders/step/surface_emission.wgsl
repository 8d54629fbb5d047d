//@ use data/hit
//@ use data/material
//@ use data/path
//@ use choice/aov_direct
//@ use choice/clamp
//@ use choice/found_light
// A surface that emits and scatters adds its emission, and the path goes on.
fn add_surface_emission(path: ptr<function, Path>, hit: Hit, evaluated: EvaluatedMaterial, bsdf: Scatter) {
    let emission = select(evaluated.emission, vec3<f32>(0.0), bsdf.event == EMITTED);
    let contribution = weigh_emission(path, hit, emission, (*path).throughput * emission);
    record_direct(path, contribution, (*path).depth);
    (*path).radiance += limited_indirect(contribution, (*path).depth);
}

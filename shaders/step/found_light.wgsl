//@ implements found_light when area_light & light & emits
//@ use choice/density_ratio
//@ use choice/probe
//@ use step/light
// Emitters that BSDF sampling hits and that light sampling samples too.

// Returns the MIS weight of the radiance that a surface emits, and records the light. The contribution is computed in the order of the
// image, so that both round alike.
fn weight_of_emission(path: ptr<function, Path>, hit: Hit, surface: Surface, radiance: vec3<f32>, event: u32) -> f32 {
    if !any(radiance > vec3<f32>(0.0)) {
        return 1.0;
    }
    let throughput = (*path).throughput;
    let weight = mis_weight(path, hit, surface.local);
    let contribution = select(throughput * radiance * weight, throughput * weight * radiance, event == EMITTED);
    record_found_light(path, hit, radiance, contribution);
    return weigh_beside_light_paths(path, hit, surface, weight);
}

//@ without
// Light sampling samples no emitter that BSDF sampling can hit.
fn weight_of_emission(path: ptr<function, Path>, hit: Hit, surface: Surface, radiance: vec3<f32>, event: u32) -> f32 {
    return 1.0;
}

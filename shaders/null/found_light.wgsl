//@ use data/hit
//@ use data/material
//@ use data/path
//@ use data/surface
// Light sampling samples no emitter that BSDF sampling can hit.
fn weight_of_emission(path: ptr<function, Path>, hit: Hit, surface: Surface, radiance: vec3<f32>, event: u32) -> f32 {
    return 1.0;
}

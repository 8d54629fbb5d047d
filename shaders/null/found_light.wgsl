//@ use data/hit
//@ use data/material
//@ use data/path
// Light sampling samples no emitter that BSDF sampling can hit.
fn weigh_emission(path: ptr<function, Path>, hit: Hit, emission: vec3<f32>, contribution: vec3<f32>) -> vec3<f32> {
    return contribution;
}

fn weigh_emitter_hit(path: ptr<function, Path>, hit: Hit, bsdf: Scatter) {
}

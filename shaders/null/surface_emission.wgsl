//@ use data/hit
//@ use data/material
//@ use data/path
// No surface emits and scatters.
fn add_surface_emission(path: ptr<function, Path>, hit: Hit, evaluated: EvaluatedMaterial, bsdf: Scatter) {
}

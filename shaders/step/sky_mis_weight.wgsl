//@ use data/path
//@ use data/light
//@ use scene/sky_light
// The MIS weight of the sky that BSDF sampling found; 1 if light sampling cannot sample it.
fn mis_weight_of_sky(path: ptr<function, Path>) -> f32 {
    let pdf = (*path).pdf;
    if !(pdf > 0.0) {
        return 1.0;
    }
    return power_heuristic(pdf, sky_density((*path).ray.origin, (*path).ray.direction));
}

//@ use data/path
//@ use data/light
//@ use scene/sky_light
// The share that the sky has which the path met by scattering: all of it, if it could not have been sampled.
fn mis_weight_of_sky(path: ptr<function, Path>) -> f32 {
    let pdf = (*path).pdf;
    if !(pdf > 0.0) {
        return 1.0;
    }
    return power_heuristic(pdf, sky_density((*path).ray.origin, (*path).ray.direction));
}

//@ implements found_sky when sky_light
//@ use choice/probe
//@ use scene/sky_light
// The sky that BSDF sampling finds, where light sampling samples it too.

// Returns the throughput of a path that leaves the scene times the MIS weight of the sky, which is 1 if light sampling cannot
// sample it.
fn weigh_sky(path: ptr<function, Path>, throughput: vec3<f32>) -> vec3<f32> {
    let pdf = (*path).pdf;
    if !(pdf > 0.0) {
        return throughput;
    }
    return throughput * power_heuristic(pdf, sky_density((*path).ray.origin, (*path).ray.direction));
}

fn record_sky(path: ptr<function, Path>, radiance: vec3<f32>, contribution: vec3<f32>) {
    record_found_sky(path, radiance, contribution);
}

//@ without
// The sky is not sampled as a light.
fn weigh_sky(path: ptr<function, Path>, throughput: vec3<f32>) -> vec3<f32> {
    return throughput;
}

fn record_sky(path: ptr<function, Path>, radiance: vec3<f32>, contribution: vec3<f32>) {
}

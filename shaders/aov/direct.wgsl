//@ implements aov_direct when aov.direct
//@ use choice/filter_weight
// The share of the radiance that is direct: light seen directly, and light on the first surface or medium of a path.

// Records a contribution of light that reaches the camera by this number of scattering events.
fn record_direct(path: ptr<function, Path>, contribution: vec3<f32>, events: u32) {
    if events < INDIRECT_FROM {
        (*path).direct += contribution;
    }
}

// Adds the direct radiance of a sample that the film accepts.
fn add_direct(path: ptr<function, Path>) {
    let direct = weigh_by_filter(path, (*path).direct);
    //@ each direct_sum
    (*path).aov[${number}u] += ${name};
    //@ end
}

//@ without
// The film has no channel of direct radiance.
fn record_direct(path: ptr<function, Path>, contribution: vec3<f32>, events: u32) {
}

fn add_direct(path: ptr<function, Path>) {
}

//@ use data/path
//@ if signed
//@ use step/start
//@ end
// The share of the radiance that is direct: light seen directly, and light on the first surface or medium of a path.

// Notes a contribution of light that reaches the camera by this number of scattering events.
fn note_direct(path: ptr<function, Path>, contribution: vec3<f32>, events: u32) {
    if events < INDIRECT_FROM {
        (*path).direct += contribution;
    }
}

// Adds the direct radiance of a sample that the film accepts.
fn add_direct(path: ptr<function, Path>) {
    var direct = (*path).direct;
    //@ if signed
    direct *= weight_of_sample(path);
    //@ end
    (*path).direct_sum += direct;
}

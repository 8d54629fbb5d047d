//@ use data/path
//@ if signed
//@ use step/start
//@ end
// The albedo and the normal of the surface that the camera sees. By default, mirrors and clear glass are passed until the path meets
// something else (`--aov-surface`).

// Notes an event of the path. `passes` tells that it is at a mirror or at clear glass. `albedo` is the path's throughput times the share of
// light that the event scatters, 1 for a light. `normal` is the shading normal, and 0 in a medium.
fn note_surface(path: ptr<function, Path>, passes: bool, albedo: vec3<f32>, normal: vec3<f32>) {
    //@ if aov_rough
    if passes || (*path).seen != 0u {
        return;
    }
    (*path).seen = 1u;
    //@ end
    //@ if aov_first
    if (*path).depth != 0u {
        return;
    }
    //@ end
    var weight = 1.0;
    //@ if signed
    weight = weight_of_sample(path);
    //@ end
    //@ if aov_albedo
    (*path).albedo_sum += weight * albedo;
    //@ end
    //@ if aov_normal
    (*path).normal_sum += weight * normal;
    //@ end
}

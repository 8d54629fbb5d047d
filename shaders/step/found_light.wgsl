//@ use data/hit
//@ use data/material
//@ use data/path
//@ use choice/probe
//@ use step/light
// Emitters that BSDF sampling hits and that light sampling samples too.

// Returns the contribution of a surface's emission times its MIS weight.
fn weigh_emission(path: ptr<function, Path>, hit: Hit, emission: vec3<f32>, contribution: vec3<f32>) -> vec3<f32> {
    if !any(emission > vec3<f32>(0.0)) {
        return contribution;
    }
    let weighed = contribution * mis_weight(path, hit);
    record_found_light(path, hit, emission, weighed);
    return weighed;
}

// Multiplies the throughput of a path that ends on an emitter by the MIS weight.
fn weigh_emitter_hit(path: ptr<function, Path>, hit: Hit, bsdf: Scatter) {
    if bsdf.event == EMITTED {
        (*path).throughput *= mis_weight(path, hit);
        record_found_light(path, hit, bsdf.weight, (*path).throughput * bsdf.weight);
    }
}

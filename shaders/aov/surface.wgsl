//@ implements aov_surface when aov_surface & !kernel.light_path
//@ use choice/filter_weight
//@ use choice/seen
//@ use scene/responses
// The albedo and the normal of the surface that the camera sees (`--aov-surface`).

// Records a BSDF sample at a surface with this shading normal. The albedo is the path's throughput times the share of light that the event
// scatters; of a light the share is 1.
fn record_surface(path: ptr<function, Path>, evaluated: EvaluatedMaterial, bsdf: Scatter, normal: vec3<f32>) {
    let passes = bsdf.event == SCATTERED && !is_non_specular(evaluated);
    let share = select(bsdf.weight, vec3<f32>(1.0), bsdf.event == EMITTED);
    record_event_seen(path, passes, (*path).throughput * share, normal);
}

// Records an event in a medium, which has no normal.
fn record_medium(path: ptr<function, Path>, albedo: vec3<f32>) {
    record_event_seen(path, false, albedo, vec3<f32>(0.0));
}

// `passes`: the event is at a mirror or at clear glass.
fn record_event_seen(path: ptr<function, Path>, passes: bool, event_albedo: vec3<f32>, event_normal: vec3<f32>) {
    if !is_seen(path, passes) {
        return;
    }
    let albedo = weigh_by_filter(path, event_albedo);
    let normal = weigh_by_filter(path, event_normal);
    //@ each surface_sum
    (*path).aov[${number}u] += ${name};
    //@ end
}

//@ without
// The film has no channel of the surface that the camera sees.
fn record_surface(path: ptr<function, Path>, evaluated: EvaluatedMaterial, bsdf: Scatter, normal: vec3<f32>) {
}

fn record_medium(path: ptr<function, Path>, albedo: vec3<f32>) {
}

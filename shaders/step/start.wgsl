//@ use data/path
//@ use data/dimension
//@ use data/primitive
//@ use bind/settings
//@ use bind/window
//@ use bind/counters
//@ use choice/camera
//@ use choice/filter
//@ use choice/sampler
//@ use step/pixel_order
//@ if light
//@ use data/light
//@ use choice/probe
//@ end
// Starting a sample, and a run.

//@ if signed
// The weight of the path's sample. Its point is drawn again: its numbers are the same.
fn weight_of_sample(path: ptr<function, Path>) -> f32 {
    let u = random4((*path).pixel, (*path).sample, DIMENSION_CAMERA, settings.seed);
    return filter_weight(u.xy);
}
//@ end

// Puts the path onto the camera ray of its sample.
fn start_sample(path: ptr<function, Path>) {
    let pixel = (*path).pixel;
    let u = random4(pixel, (*path).sample, DIMENSION_CAMERA, settings.seed);
    let jitter = vec4<f32>(filter_point(u.xy), u.zw);
    (*path).ray = camera_ray(pixel % settings.image_width, pixel / settings.image_width, jitter);
    (*path).status = RAY_READY;
    (*path).throughput = vec3<f32>(1.0);
    (*path).depth = 0u;
    //@ if aov_direct
    (*path).direct = vec3<f32>(0.0);
    //@ end
    //@ if aov_rough
    (*path).seen = 0u;
    //@ end
    //@ if gathers
    (*path).radiance = vec3<f32>(0.0);
    (*path).pdf = 0.0;
    //@ end
    //@ if light
    (*path).light = NO_LIGHT;
    start_history(path);
    //@ end
}

// Takes the window's next run, or leaves the slot idle where there is none.
fn start_run(path: ptr<function, Path>) {
    let run = atomicAdd(&counters.next, 1u);
    if run >= window.end {
        (*path).status = SLOT_IDLE;
        atomicAdd(&counters.idle, 1u);
        return;
    }
    let block = window.first_block + run / window.pixels;
    (*path).pixel = pixel_in_order(window.first_pixel + run % window.pixels);
    (*path).sample = max(block * RUN_LENGTH, settings.first_sample);
    (*path).counts = select(0u, ODD_RUN, (block & 1u) == 1u);
    (*path).sum = Compensated();
    (*path).rays = 0u;
    (*path).spread = vec3<f32>(0.0);
    //@ if aov_direct
    (*path).direct_sum = vec3<f32>(0.0);
    //@ end
    //@ if aov_albedo
    (*path).albedo_sum = vec3<f32>(0.0);
    //@ end
    //@ if aov_normal
    (*path).normal_sum = vec3<f32>(0.0);
    //@ end
    //@ if aov_hits
    (*path).hits = 0.0;
    //@ end
    //@ if aov_depth
    (*path).depth_sum = 0.0;
    //@ end
    //@ if aov_position
    (*path).position_sum = vec3<f32>(0.0);
    //@ end
    //@ if aov_object
    (*path).object = 0.0;
    //@ end
    //@ if aov_material
    (*path).material = 0.0;
    //@ end
    start_sample(path);
}

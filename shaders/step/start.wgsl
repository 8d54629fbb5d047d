//@ use bind/settings
//@ use bind/window
//@ use bind/counters
//@ use choice/camera
//@ use choice/camera_direction
//@ use choice/filter
//@ use choice/sampler
//@ use choice/time
//@ use step/pixel_order
//@ use choice/probe
//@ use choice/aov_record
//@ use choice/light_groups
//@ use choice/mark_of_run
// Starts a sample or a run.

// Where a sample is in its pixel, from the left upper corner, and the random numbers of its point on the lens.
fn pixel_offset(path: ptr<function, Path>) -> vec4<f32> {
    let u = random4((*path).pixel, (*path).sample, DIMENSION_CAMERA, settings.seed);
    return vec4<f32>(filter_point(u.xy), u.zw);
}

// Puts the path onto the camera ray of its sample.
fn start_sample(path: ptr<function, Path>) {
    let pixel = (*path).pixel;
    begin_time(path);
    (*path).ray = camera_ray(pixel % settings.image_width, pixel / settings.image_width, pixel_offset(path));
    (*path).status = RAY_READY;
    (*path).throughput = vec3<f32>(select(0.0, 1.0, has_direction((*path).ray)));
    (*path).depth = 0u;
    (*path).direct = vec3<f32>(0.0);
    begin_lights(path);
    (*path).seen = 0u;
    (*path).radiance = vec3<f32>(0.0);
    (*path).pdf = 0.0;
    (*path).log_ratio = 0.0;
    (*path).light = NO_LIGHT;
    start_history(path);
}

// Takes the window's next run, or leaves the slot idle if there is none. Returns whether there is one.
fn start_run(path: ptr<function, Path>) -> bool {
    let run = atomicAdd(&counters.next, 1u);
    if run >= window.end {
        (*path).status = SLOT_IDLE;
        atomicAdd(&counters.idle, 1u);
        return false;
    }
    let block = window.first_block + run / window.pixels;
    (*path).pixel = pixel_in_order(window.first_pixel + run % window.pixels);
    (*path).sample = max(block * RUN_LENGTH, settings.first_sample);
    (*path).counts = select(0u, ODD_RUN, (block & 1u) == 1u) | mark_of_run(path);
    (*path).sum = Compensated();
    (*path).rays = 0u;
    (*path).squares = vec3<f32>(0.0);
    clear_aov(path);
    return true;
}

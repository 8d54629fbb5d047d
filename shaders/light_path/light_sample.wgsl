//@ use bind/counters
//@ use bind/lights
//@ use bind/settings
//@ use bind/window
//@ use choice/delta_lights
//@ use choice/light_absorption
//@ use choice/sampler
//@ use choice/time
//@ use light_path/emission
//@ use scene/lights
//@ use light_path/counted_splat
// The start of light paths. A block of samples of all pixels has the light paths 0, 1, ... of pixel 0, then those of pixel 1, and so on. Their
// numbers are the samples of one sequence over the whole image, which is more even than a sequence for each pixel. The blocks of a pair are
// the two halves of the sampler.

// Whether the run is even or odd.
fn half_of_light_path(path: ptr<function, Path>) -> u32 {
    return ((*path).sample / RUN_LENGTH) & 1u;
}

// Takes the window's next light path, or leaves the slot idle if there is none. Returns whether there is one.
fn start_light_path(path: ptr<function, Path>) -> bool {
    let number = atomicAdd(&counters.next, 1u);
    if number >= window.end {
        (*path).status = SLOT_IDLE;
        atomicAdd(&counters.idle, 1u);
        return false;
    }
    let of_block = settings.image_width * settings.image_height * settings.light_paths;
    let block = window.first_block + number / of_block;
    let within = number % of_block;
    (*path).pixel = block / 2u;
    (*path).sample = (within / RUN_LENGTH * 2u + (block & 1u)) * RUN_LENGTH + within % RUN_LENGTH;
    (*path).status = PATH_ENDED;
    (*path).light = NO_LIGHT;
    // Each sample of a block has an equal share of its light paths, so that parts of a run have the light paths of all of it.
    let of_sample = (of_block + RUN_LENGTH - 1u) / RUN_LENGTH;
    let sample = block * RUN_LENGTH + within / of_sample;
    if sample >= settings.first_sample && sample < settings.end_sample {
        emit_light_path(path);
    }
    return true;
}

fn emit_light_path(path: ptr<function, Path>) {
    let u = random4((*path).pixel, (*path).sample, DIMENSION_EMISSION, settings.seed);
    let v = random4((*path).pixel, (*path).sample, DIMENSION_EMITTED_DIRECTION, settings.seed);
    begin_time(path);
    let choice = draw_emitter(u.x);
    let emitted = emit_light(choice, u.yzw, v.xy);
    (*path).light_paths[half_of_light_path(path)] += 1u;
    if !any(emitted.weight > vec3<f32>(0.0)) {
        return;
    }
    (*path).ray = emitted.ray;
    (*path).radiance = emitted.weight;
    (*path).throughput = vec3<f32>(1.0);
    (*path).depth = FIRST_LIGHT_EVENT;
    (*path).pdf = 0.0;
    (*path).status = RAY_READY;
    absorb_nothing_ahead(path);
    (*path).log_ratio = log2(emitted.density);
    record_start(path, choice.index, emitted.radiance);
    if emitted.is_parallel {
        (*path).shadow = Ray(emitted.ray.origin, -emitted.ray.direction);
        (*path).light = HIT_NOTHING;
        (*path).lens_distance = VERY_FAR;
    }
}

// The light at which the path has started.
fn start_of_light_path(path: ptr<function, Path>) -> u32 {
    return draw_emitter(random4((*path).pixel, (*path).sample, DIMENSION_EMISSION, settings.seed).x).index;
}

// The density with which light sampling at a point draws the direction back to that light.
fn density_of_sampling(light_index: u32, from_point: vec3<f32>, to_light: vec3<f32>) -> f32 {
    let light = lights[light_index];
    if is_delta_light(light.code) {
        return light_probability(light_index, from_point) * direction_to_delta_light(light.code, from_point).pdf;
    }
    return density_of_light(light_index, light.code, light.instance, from_point, to_light);
}

// Ends a light path. One whose walk took too many steps is counted.
fn end_light_path(path: ptr<function, Path>) {
    if (*path).status == PATH_CUT {
        atomicAdd(&counters.cut, 1u);
    }
    (*path).status = PATH_ENDED;
}

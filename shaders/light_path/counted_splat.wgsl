//@ use bind/lights
//@ use bind/settings
//@ use scene/lights
//@ use step/counted_light
// Light paths begin with a narrow or specular lobe. So their contributions to pixels count as light that was found in one.

// Keeps the bin of the light at which the path starts.
fn record_start(path: ptr<function, Path>, light_index: u32, radiance: vec3<f32>) {
    let light = lights[light_index];
    var hit = hit_at(light.code, 0.0);
    hit.instance = light.instance;
    (*path).bin = bin_of_light(number_of_light(hit), radiance);
}

// Counts what was added to a pixel. A pixel has the mean over its light paths, so that a splat stands for its share of the camera samples.
fn record_splat(path: ptr<function, Path>, value: vec3<f32>) {
    add_light(words_of_count(path), (*path).bin, FOUND, value * (f32(RUN_LENGTH) / f32(settings.light_paths)));
}

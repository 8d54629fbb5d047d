//@ implements splat_lights when aov.lights
//@ use bind/lights
//@ use choice/light_groups
//@ use light_path/light_sample
//@ use step/film
// Light paths by groups of lights.

// Adds what a light path has added to a pixel to the group of its light.
fn splat_light(path: ptr<function, Path>, pixel: u32, value: vec3<f32>, half: u32) {
    let light = lights[start_of_light_path(path)];
    var hit = hit_at(light.code, 0.0);
    hit.instance = light.instance;
    let group = group_of_light(hit);
    if group >= LIGHT_GROUPS {
        return;
    }
    for (var i = 0u; i < 3u; i++) {
        add_to_film(pixel, FIRST_LIGHT_SUM + ${sums_of_group}u * group + 6u + 3u * half + i, value[i], SUM_FRACTION);
    }
}

//@ without
// The film has no groups of lights.
fn splat_light(path: ptr<function, Path>, pixel: u32, value: vec3<f32>, half: u32) {
}

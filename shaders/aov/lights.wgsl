//@ implements light_groups when aov.lights
//@ use bind/light_groups
//@ use choice/delta_lights
//@ use choice/filter_weight
//@ use choice/surface_group
// The radiance by groups of lights.

const LIGHT_GROUPS: u32 = ${light_groups}u;
const BACKGROUND_GROUP: u32 = ${background_group}u;

// The number of the group of the light that was hit; LIGHT_GROUPS or more if it has none.
fn group_of_light(hit: Hit) -> u32 {
    if is_delta_light(hit.code) {
        return light_groups[primitive_index(hit.code)];
    }
    if hit.code == HIT_NOTHING {
        return BACKGROUND_GROUP;
    }
    return group_of_surface(hit);
}

fn begin_lights(path: ptr<function, Path>) {
    for (var group = 0u; group < LIGHT_GROUPS; group++) {
        (*path).light_of_group[group] = vec3<f32>(0.0);
    }
}

// Records a contribution of the light that was hit.
fn record_light(path: ptr<function, Path>, hit: Hit, contribution: vec3<f32>) {
    let group = group_of_light(hit);
    if group < LIGHT_GROUPS {
        (*path).light_of_group[group] += contribution;
    }
}

// Adds the light of a sample that the film accepts.
fn add_lights(path: ptr<function, Path>) {
    for (var group = 0u; group < LIGHT_GROUPS; group++) {
        let light = weigh_by_filter(path, (*path).light_of_group[group]);
        for (var i = 0u; i < 3u; i++) {
            (*path).aov[${plain_sums}u + 3u * group + i] += light[i];
        }
    }
}

//@ without
// The film has no groups of lights.
fn begin_lights(path: ptr<function, Path>) {
}

fn record_light(path: ptr<function, Path>, hit: Hit, contribution: vec3<f32>) {
}

fn add_lights(path: ptr<function, Path>) {
}

//@ use data/hit
//@ use data/material
//@ use data/path
// No lobe of the scene hides light from light sampling: nothing is counted.

fn pack_depth(path: ptr<function, Path>) -> u32 {
    return (*path).depth;
}

fn unpack_depth(path: ptr<function, Path>, word: u32) {
    (*path).depth = word;
}

fn start_history(path: ptr<function, Path>) {
}

fn sends_probe(path: ptr<function, Path>, lobe: u32) -> bool {
    return false;
}

fn aim_probe(path: ptr<function, Path>, probes: bool, drawn: Scatter, to_light: vec3<f32>, normal: vec3<f32>, share: f32) {
}

fn is_probe(path: ptr<function, Path>) -> bool {
    return false;
}

fn weigh_probe(path: ptr<function, Path>, pdf: f32) {
}

fn record_event(path: ptr<function, Path>, lobe: u32, share: f32) {
}

fn record_found_light(path: ptr<function, Path>, hit: Hit, radiance: vec3<f32>, contribution: vec3<f32>) {
}

fn record_found_sky(path: ptr<function, Path>, radiance: vec3<f32>, contribution: vec3<f32>) {
}

fn record_light_of_shadow(path: ptr<function, Path>, hit: Hit, emitted: vec3<f32>, arriving: vec3<f32>) {
}

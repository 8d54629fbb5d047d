//@ use data/path
//@ use data/surface
// No solid absorbs light.
fn absorb_ahead(path: ptr<function, Path>, surface: Surface, direction: vec3<f32>) {
}

fn absorb_nothing_ahead(path: ptr<function, Path>) {
}

fn absorb_ray(path: ptr<function, Path>, distance: f32) {
}

fn absorb_to_lens(light: vec3<f32>, surface: Surface, direction: vec3<f32>, distance: f32) -> vec3<f32> {
    return light;
}

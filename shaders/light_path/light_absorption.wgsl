//@ implements light_absorption when kernel.light_path & absorbing
//@ use bind/extensions
// Absorption inside solids along light paths. A camera path is absorbed where its ray ends on the inside of an absorbing solid. For a light
// path that is where its ray starts.

fn absorption_ahead(surface: Surface, direction: vec3<f32>) -> vec3<f32> {
    let is_outside = dot(direction, surface.normal) > 0.0;
    return select(extensions[surface.material].absorption, vec3<f32>(0.0), is_outside);
}

// Sets what absorbs the next ray, which leaves the surface in this direction.
fn absorb_ahead(path: ptr<function, Path>, surface: Surface, direction: vec3<f32>) {
    (*path).absorption = absorption_ahead(surface, direction);
}

fn absorb_nothing_ahead(path: ptr<function, Path>) {
    (*path).absorption = vec3<f32>(0.0);
}

// Absorbs the path's ray up to this distance.
fn absorb_ray(path: ptr<function, Path>, distance: f32) {
    (*path).throughput *= exp(-distance * (*path).absorption);
}

// The share of light that is left at the lens.
fn absorb_to_lens(light: vec3<f32>, surface: Surface, direction: vec3<f32>, distance: f32) -> vec3<f32> {
    return light * exp(-distance * absorption_ahead(surface, direction));
}

//@ without
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

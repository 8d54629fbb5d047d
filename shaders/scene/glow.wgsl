//@ use data/hit
//@ use data/material
//@ use data/surface
//@ use scene/details
// What surfaces emit to shadow rays in scenes where some emit and scatter.

// The radiance that a surface emits to a ray that hits it, from the front or not.
fn glow_of_surface(hit: Hit, surface: Surface, front: bool) -> vec3<f32> {
    let emission = details[surface.material].emission;
    if emission == NO_DETAIL || (materials[emission].parameter == 0.0 && !front) {
        return vec3<f32>(0.0);
    }
    return detail_colour(emission, hit, surface);
}

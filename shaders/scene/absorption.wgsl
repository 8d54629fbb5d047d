//@ use data/material
//@ use data/surface
//@ use bind/details
// What is left of light after a distance through the inside of a clear solid, by the material of the surface that it meets from there
// (Beer and Lambert). `front` tells that it comes from outside.
fn left_by_absorption(surface: Surface, front: bool, distance: f32) -> vec3<f32> {
    let left = exp(-distance * details[surface.material].absorption);
    return select(left, vec3<f32>(1.0), front);
}

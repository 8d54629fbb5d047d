//@ use data/material
//@ use data/surface
//@ use bind/extensions
// The throughput after a distance through the inside of a clear solid, by the material of the surface that the ray meets from there
// (Beer and Lambert). `front` tells that it comes from outside.
fn absorb_inside(throughput: vec3<f32>, surface: Surface, front: bool, distance: f32) -> vec3<f32> {
    let left = exp(-distance * extensions[surface.material].absorption);
    return throughput * select(left, vec3<f32>(1.0), front);
}

//@ implements absorption when absorbing
//@ use bind/extensions
// Returns the throughput after a distance through the inside of a solid, by the Beer-Lambert law. The absorption is that of the surface
// that the ray hits. A ray that hits its front comes from outside, and nothing is absorbed.
fn absorb_inside(throughput: vec3<f32>, surface: Surface, front: bool, distance: f32) -> vec3<f32> {
    let kept = exp(-distance * extensions[surface.material].absorption);
    return throughput * select(kept, vec3<f32>(1.0), front);
}

//@ without
// No inside absorbs.
fn absorb_inside(throughput: vec3<f32>, surface: Surface, front: bool, distance: f32) -> vec3<f32> {
    return throughput;
}

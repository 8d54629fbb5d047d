//@ use data/surface
// No inside absorbs.
fn absorb_inside(throughput: vec3<f32>, surface: Surface, front: bool, distance: f32) -> vec3<f32> {
    return throughput;
}

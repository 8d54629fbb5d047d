//@ use data/hit
//@ use data/surface
// No mesh emits by the colours of its vertices.
fn times_vertex_emission(radiance: vec3<f32>, hit: Hit, surface: Surface) -> vec3<f32> {
    return radiance;
}

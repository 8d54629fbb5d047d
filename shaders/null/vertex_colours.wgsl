//@ use data/hit
//@ use data/surface
// No mesh has colours of vertices.
fn times_vertex_colour(colour: vec3<f32>, hit: Hit, surface: Surface) -> vec3<f32> {
    return colour;
}

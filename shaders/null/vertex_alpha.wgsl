//@ use data/hit
//@ use data/surface
// No mesh has an alpha of its vertices.
fn times_vertex_alpha(alpha: f32, hit: Hit, surface: Surface) -> f32 {
    return alpha;
}

//@ use data/motion
//@ use data/primitive
//@ use data/surface
//@ use lib/tangents
// Quads rest.
fn moved_quad(quad: Quad, pose: Pose) -> Quad {
    return quad;
}

fn quad_at_rest(surface: Surface, quad: Quad) -> Surface {
    return surface;
}

fn quad_unturned(surface: Surface) -> Surface {
    return surface;
}

fn quad_tangents_with(tangents: Tangents, pose: Pose) -> Tangents {
    return tangents;
}

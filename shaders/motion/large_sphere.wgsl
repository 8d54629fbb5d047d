//@ implements moved_large_sphere when moves.large_sphere | boundary_moves.large_sphere
//@ use motion/turned_surface
// Large spheres that move. Their own point is the centre, or the point that is nearest to the camera at rest: the one that moves less. A large
// sphere is given by any of its points with the normal there. As long as the centre is its own point, the point that was nearest is shifted with it and
// not turned around it, so that it stays near.

fn moved_large_sphere(large_sphere: LargeSphere, pose: Pose) -> LargeSphere {
    if !pose.moves {
        return large_sphere;
    }
    var moved = large_sphere;
    moved.curvature /= pose.scale;
    moved.nearest += pose.shift;
    if large_sphere.follows_nearest == 1u {
        moved.inward = normalize(apply_turn(pose.turn, large_sphere.inward));
    } else {
        moved.nearest += ((1.0 - pose.scale) / large_sphere.curvature) * large_sphere.inward;
    }
    return moved;
}

// Returns the surface with its local coordinates in the pose at rest. With n the inward normal at the point that was nearest,
// local - n is the direction from the centre, which turns.
fn large_sphere_at_rest(surface: Surface, large_sphere: LargeSphere) -> Surface {
    if !surface.pose.moves {
        return surface;
    }
    let back = inverse_turn(surface.pose.turn);
    var rest = surface;
    rest.local = apply_turn(back, surface.local);
    if large_sphere.follows_nearest == 0u {
        rest.local -= change_by_turn(back, large_sphere.inward);
    }
    return rest;
}

fn large_sphere_unturned(surface: Surface) -> Surface {
    return unturned_surface(surface);
}

fn large_sphere_tangents_with(tangents: Tangents, pose: Pose) -> Tangents {
    return turned_tangents(tangents, pose);
}

//@ without
// Large spheres rest.
fn moved_large_sphere(large_sphere: LargeSphere, pose: Pose) -> LargeSphere {
    return large_sphere;
}

fn large_sphere_at_rest(surface: Surface, large_sphere: LargeSphere) -> Surface {
    return surface;
}

fn large_sphere_unturned(surface: Surface) -> Surface {
    return surface;
}

fn large_sphere_tangents_with(tangents: Tangents, pose: Pose) -> Tangents {
    return tangents;
}

// The frame of a normal map of an object that moves: its tangents are found at rest, and turned.

// Returns the surface with the normal that it has at rest.
fn unturned_surface(surface: Surface) -> Surface {
    if !surface.pose.moves {
        return surface;
    }
    var rest = surface;
    rest.normal = apply_turn(inverse_turn(surface.pose.turn), surface.normal);
    return rest;
}

fn turned_tangents(tangents: Tangents, pose: Pose) -> Tangents {
    if !pose.moves {
        return tangents;
    }
    return Tangents(apply_turn(pose.turn, tangents.u), apply_turn(pose.turn, tangents.v));
}

//@ implements moved_triangle when moves.triangle | boundary_moves.triangle
//@ use geometry/triangle
//@ use motion/turned_axes
// Meshes that move. Their own point is the mesh's origin. What a face has in the mesh's space moves with the instance.

fn moved_instance(instance: Instance, pose: Pose) -> Instance {
    if !pose.moves {
        return instance;
    }
    var moved = instance;
    moved.translation += pose.shift;
    moved.scale *= pose.scale;
    let axes = turned_axes(pose, instance.x_axis, instance.y_axis);
    moved.x_axis = axes.x;
    moved.y_axis = axes.y;
    return moved;
}

fn moved_triangle(triangle: Triangle, pose: Pose) -> Triangle {
    return Triangle(moved_instance(triangle.instance, pose), triangle.face, triangle.light);
}

fn triangle_at_rest(surface: Surface, triangle: Triangle) -> Surface {
    return surface;
}

fn triangle_unturned(surface: Surface) -> Surface {
    return surface;
}

fn triangle_tangents_with(tangents: Tangents, pose: Pose) -> Tangents {
    return tangents;
}

//@ without
//@ use geometry/triangle
// Meshes rest.
fn moved_instance(instance: Instance, pose: Pose) -> Instance {
    return instance;
}

fn moved_triangle(triangle: Triangle, pose: Pose) -> Triangle {
    return triangle;
}

fn triangle_at_rest(surface: Surface, triangle: Triangle) -> Surface {
    return surface;
}

fn triangle_unturned(surface: Surface) -> Surface {
    return surface;
}

fn triangle_tangents_with(tangents: Tangents, pose: Pose) -> Tangents {
    return tangents;
}

//@ implements moved_instance when moves.triangle | boundary_moves.triangle
//@ use data/motion
//@ use data/primitive
//@ use motion/turned_axes
// Instances of meshes that move. Their own point is the mesh's origin.

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

//@ without
//@ use data/motion
//@ use data/primitive
// Meshes rest.
fn moved_instance(instance: Instance, pose: Pose) -> Instance {
    return instance;
}

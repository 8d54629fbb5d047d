//@ use data/motion
//@ use data/primitive
//@ use lib/quaternion
// Instances of meshes that move. Their own point is the mesh's origin.

fn moved_instance(instance: Instance, pose: Pose) -> Instance {
    if !pose.moves {
        return instance;
    }
    var moved = instance;
    moved.translation += pose.shift;
    moved.scale *= pose.scale;
    // Perpendicular again, as geometry/instance takes them to be.
    moved.x_axis = normalize(apply_turn(pose.turn, instance.x_axis));
    let y_axis = apply_turn(pose.turn, instance.y_axis);
    moved.y_axis = normalize(y_axis - dot(y_axis, moved.x_axis) * moved.x_axis);
    return moved;
}

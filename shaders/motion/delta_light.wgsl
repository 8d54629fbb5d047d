//@ implements moved_delta_light when moving_light
//@ use motion/pose
// Lights without size that move. The own point of a directional light, which has none, is of no account.

fn moved_delta_light(light: DeltaLight, index: u32) -> DeltaLight {
    let pose = pose_of((motions[0].z + index) | MOVES);
    var moved = light;
    let direction = apply_turn(pose.turn, light.position);
    moved.position = select(direction, light.position + pose.shift, light.has_position > 0.0);
    moved.axis = apply_turn(pose.turn, light.axis);
    return moved;
}

//@ without
// Lights without size rest.
fn moved_delta_light(light: DeltaLight, index: u32) -> DeltaLight {
    return light;
}

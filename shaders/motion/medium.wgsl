//@ implements moved_medium when moving_medium
//@ use motion/boundaries
// Textures of media that move.

// The offset of a point from the medium's own point, in the pose at rest. The row behind that of a medium's boundary is that of its texture.
fn offset_at_rest(medium: Medium, point: vec3<f32>) -> vec3<f32> {
    let offset = point - medium.center;
    let pose = pose_of((order_of_boundary(medium.boundary) + 1u) | MOVES);
    return apply_turn(inverse_turn(pose.turn), offset - pose.shift) / pose.scale;
}

// A direction in the pose at rest. The length is that in the pose at rest.
fn direction_at_rest(medium: Medium, direction: vec3<f32>) -> vec3<f32> {
    let pose = pose_of((order_of_boundary(medium.boundary) + 1u) | MOVES);
    return apply_turn(inverse_turn(pose.turn), direction) / pose.scale;
}

//@ without
// The textures of media rest.
fn offset_at_rest(medium: Medium, point: vec3<f32>) -> vec3<f32> {
    return point - medium.center;
}

fn direction_at_rest(medium: Medium, direction: vec3<f32>) -> vec3<f32> {
    return direction;
}

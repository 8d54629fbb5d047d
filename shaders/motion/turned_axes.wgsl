// The axes of a box or of a mesh in a pose.

struct TurnedAxes {
    x: vec3<f32>,
    y: vec3<f32>,
}

// They are perpendicular again, as geometry/cuboid and geometry/instance take them to be.
fn turned_axes(pose: Pose, x_axis: vec3<f32>, y_axis: vec3<f32>) -> TurnedAxes {
    let x = normalize(apply_turn(pose.turn, x_axis));
    let y = apply_turn(pose.turn, y_axis);
    return TurnedAxes(x, normalize(y - dot(y, x) * x));
}

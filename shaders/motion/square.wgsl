// Quads, and the squares around disks, that move. Their own point is the corner.

fn largest_of(v: vec3<f32>) -> f32 {
    let size = abs(v);
    return max(max(size.x, size.y), size.z);
}

// The bounds of errors are those of the host for a quad that rests there (src/shape/quad.rs), doubled: the edges and the normal are
// turned in f32, each off by four roundings.
fn moved_square(square: Quad, pose: Pose) -> Quad {
    if !pose.moves {
        return square;
    }
    var moved = square;
    moved.corner += pose.shift;
    moved.normal = normalize(apply_turn(pose.turn, square.normal));
    moved.a_axis = apply_turn(pose.turn, square.a_axis) / pose.scale;
    moved.b_axis = apply_turn(pose.turn, square.b_axis) / pose.scale;
    moved.u = pose.scale * apply_turn(pose.turn, square.u);
    moved.v = pose.scale * apply_turn(pose.turn, square.v);
    moved.error = 16.0 * UNIT_ROUNDOFF * (largest_of(moved.corner) + largest_of(moved.u) + largest_of(moved.v));
    let sum = 2.0 * abs(moved.corner) + 10.0 * (abs(moved.u) + abs(moved.v));
    moved.error_across = 2.0 * UNIT_ROUNDOFF * dot(abs(moved.normal), sum);
    return moved;
}

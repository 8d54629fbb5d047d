//@ use data/motion
// No boundary of a medium moves.
fn pose_of_boundary(code: u32) -> Pose {
    return Pose();
}

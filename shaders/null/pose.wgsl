//@ use data/motion
// No object moves.
fn pose_at(code: u32, instance: u32) -> Pose {
    return Pose();
}

fn place_of(order: u32) -> u32 {
    return order;
}

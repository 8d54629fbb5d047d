//@ use data/hit
//@ use data/motion
//@ use data/ray
// No surface is a pane.
const ANY_HIT_ENDS_WALK: bool = true;

fn begin_of_walk() -> f32 {
    return 0.0;
}

fn distance_ahead(candidate: Hit, pose: Pose, ray: Ray) -> f32 {
    return candidate.t;
}

fn may_end_walk(candidate: Hit) -> bool {
    return true;
}

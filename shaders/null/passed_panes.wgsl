//@ use data/hit
//@ use data/ray
// No surface is a pane.
fn distance_ahead(candidate: Hit, ray: Ray) -> f32 {
    return candidate.t;
}

fn may_end_walk(candidate: Hit) -> bool {
    return true;
}

//@ implements time0 when motion
//@ use motion/pose
// The time of the sample while the shutter is open.
fn time0() -> f32 {
    return now;
}

//@ without
// Nothing moves while the shutter is open.
fn time0() -> f32 {
    return 0.0;
}

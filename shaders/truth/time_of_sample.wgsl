//@ implements time_of_sample when motion
//@ use motion/pose
// The time of the sample while the shutter is open.
fn time_of_sample() -> f32 {
    return now;
}

//@ without
// Nothing moves while the shutter is open.
fn time_of_sample() -> f32 {
    return 0.0;
}

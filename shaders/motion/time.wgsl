//@ implements time when motion
//@ use bind/settings
//@ use choice/camera_pose
//@ use choice/sampler
//@ use motion/pose
// Sets the time to that of the path's sample, and the camera to where it is then. The samples of a pixel are stratified over the time in which the
// shutter is open.
fn begin_time(path: ptr<function, Path>) {
    now = random4((*path).pixel, (*path).sample, DIMENSION_TIME, settings.seed).x;
    begin_camera();
}

//@ without
// Nothing moves.
fn begin_time(path: ptr<function, Path>) {
}

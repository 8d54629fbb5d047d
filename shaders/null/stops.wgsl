//@ use data/hit
//@ use data/motion
//@ use data/ray
// All surfaces stop all light.
fn stops_before(candidate: ptr<function, Hit>, hit: Hit, pose: Pose, ray: Ray) -> bool {
    return true;
}

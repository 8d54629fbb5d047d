//@ implements stops when alpha & !alpha_body
//@ use scene/coverage
// Surfaces that a ray crosses once may let it pass.
fn stops_before(candidate: ptr<function, Hit>, hit: Hit, pose: Pose, ray: Ray) -> bool {
    return is_stopped(*candidate, ray, COVERAGE);
}

//@ without
// All surfaces stop all light.
fn stops_before(candidate: ptr<function, Hit>, hit: Hit, pose: Pose, ray: Ray) -> bool {
    return true;
}

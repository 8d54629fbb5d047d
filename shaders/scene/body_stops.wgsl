//@ implements stops when alpha_body
//@ use scene/coverage
//@ use choice/crossings
//@ use scene/primitives
// Spheres and boxes may let a ray pass their near side, and then meet it with their far side.

// Whether the primitive stops the ray before this hit. Then the candidate is the crossing that does.
fn stops_before(candidate: ptr<function, Hit>, hit: Hit, pose: Pose, ray: Ray) -> bool {
    let leaves = interval_of_body((*candidate).code, pose, ray).y;
    var crossing = with_side(*candidate, pose, ray);
    // One call for both sides, because compilers inline the functions of all materials at each call.
    for (var side = 0u; side < 2u; side++) {
        let is_far = crossing.instance == FAR_SIDE;
        if is_stopped(crossing, ray, select(COVERAGE, COVERAGE_OF_FAR_SIDE, is_far)) {
            *candidate = crossing;
            return true;
        }
        crossing.t = leaves;
        crossing.instance = FAR_SIDE;
        let is_nearer = leaves < hit.t || (leaves == hit.t && comes_before(crossing, hit));
        if is_far || !(leaves > (*candidate).t) || !is_nearer {
            break;
        }
    }
    return false;
}

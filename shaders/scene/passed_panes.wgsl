//@ implements passed_panes when pane
//@ use choice/crossings
//@ use scene/panes
//@ use scene/primitives
// Where on a ray a walk begins: behind the last pane that the ray has passed. The hits of a ray are in the order of their distances, and at
// one distance in the order of the scene. So a ray meets each crossing once.

// Where all lanes test the same primitives, a walk ends sooner if it does not look at the material of each hit: 15 primitives took 1.1 times as
// long with the look (scene/brute_force).
const ANY_HIT_ENDS_WALK: bool = false;

// The last pane.
var<private> passed: Hit;

fn pass_no_pane() {
    passed = hit_at(HIT_NOTHING, 0.0);
}

fn pass_pane(pane: Hit) {
    passed = pane;
}

// The distance from which on a walk takes hits.
fn begin_of_walk() -> f32 {
    return passed.t;
}

// The distance to the first crossing of a primitive that lies behind the last pane, or NO_HIT. `candidate` is the nearest crossing.
fn distance_ahead(candidate: Hit, pose: Pose, ray: Ray) -> f32 {
    let is_ahead = candidate.t > passed.t || (candidate.t == passed.t && comes_before(passed, candidate));
    if is_ahead || candidate.t == NO_HIT {
        return candidate.t;
    }
    let leaves = interval_of_body(candidate.code, pose, ray).y;
    return select(NO_HIT, leaves, leaves > passed.t);
}

// Whether a walk that looks for any hit may end with this one. A pane may let the ray pass.
fn may_end_walk(candidate: Hit) -> bool {
    return !may_be_pane(candidate);
}

//@ without
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

//@ implements object0 when truth & surface
//@ use truth/word
//@ use scene/primitives
// The number of the object that is hit, from 1; 0 is none.
fn object0_of(path: ptr<function, Path>) -> u32 {
    if !has_hit(path) {
        return 0u;
    }
    return primitive_order(path_hit(path)) + 1u;
}

//@ without
// There is no surface to hit.
fn object0_of(path: ptr<function, Path>) -> u32 {
    return 0u;
}

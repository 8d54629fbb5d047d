//@ implements object_of_hit when surface
//@ use scene/primitives
// The number of the object that a path has hit, from 1.
fn object_of_hit(path: ptr<function, Path>) -> u32 {
    return primitive_order(path_hit(path)) + 1u;
}

//@ without
// There is no surface to hit.
fn object_of_hit(path: ptr<function, Path>) -> u32 {
    return 0u;
}

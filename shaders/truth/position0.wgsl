//@ use truth/word
// The point of the hit, in render space.
fn position0_of(path: ptr<function, Path>) -> vec3<u32> {
    let point = (*path).ray.origin + (*path).t * (*path).ray.direction;
    return select(vec3<u32>(0u), words_of(point), has_hit(path));
}

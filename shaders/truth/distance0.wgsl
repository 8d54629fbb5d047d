//@ use truth/word
// The distance to the hit along the ray.
fn distance0_of(path: ptr<function, Path>) -> u32 {
    return select(0u, word_of((*path).t), has_hit(path));
}

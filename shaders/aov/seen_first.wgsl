//@ implements seen when !aov_rough
// The camera sees the first event of a path.
fn is_seen(path: ptr<function, Path>, passes: bool) -> bool {
    return (*path).depth == 0u;
}

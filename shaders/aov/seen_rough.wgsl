//@ implements seen when aov_rough
// The camera sees the first event of a path that is not at a mirror or at clear glass.
fn is_seen(path: ptr<function, Path>, passes: bool) -> bool {
    if passes || (*path).seen != 0u {
        return false;
    }
    (*path).seen = 1u;
    return true;
}

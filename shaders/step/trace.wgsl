//@ use data/path
//@ use bind/settings
//@ use choice/walk
//@ use choice/coverage
// Finds the nearest hit of the path's ray. Returns the number of steps.
fn trace(path: ptr<function, Path>) -> u32 {
    begin_walk(path, DIMENSION_SCATTER);
    let hit = nearest_hit((*path).ray, settings.root);
    (*path).t = hit.t;
    (*path).status = hit.code;
    (*path).instance = hit.instance;
    return hit.steps;
}

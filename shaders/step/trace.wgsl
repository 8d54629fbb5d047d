//@ use choice/coverage
//@ use choice/panes
// Finds the nearest hit of the path's ray. Returns the number of steps.
fn trace(path: ptr<function, Path>) -> u32 {
    begin_walk(path, DIMENSION_SCATTER);
    let hit = hit_of_path(path);
    (*path).t = hit.t;
    (*path).status = hit.code;
    (*path).instance = hit.instance;
    return hit.steps;
}

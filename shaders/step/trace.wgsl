//@ use choice/camera_direction
//@ use choice/walker
//@ use choice/panes
// Finds the nearest hit of the path's ray. Without a direction the path ends at the camera. Returns the number of steps.
fn trace(path: ptr<function, Path>) -> u32 {
    begin_walk(path, DIMENSION_SCATTER);
    let hit = hit_of_path(path);
    let goes_on = has_direction((*path).ray);
    (*path).t = select(0.0, hit.t, goes_on);
    (*path).status = select(PATH_ENDED, hit.code, goes_on);
    (*path).instance = hit.instance;
    return hit.steps;
}

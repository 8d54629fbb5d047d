//@ use data/path
//@ use bind/settings
//@ use choice/walk
// Finds the nearest hit of the path's ray.
fn trace(path: ptr<function, Path>) -> u32 {
    let hit = nearest_hit((*path).ray, settings.root);
    (*path).t = hit.t;
    (*path).status = hit.code;
    //@ if mesh
    (*path).instance = hit.instance;
    //@ end
    return hit.steps;
}

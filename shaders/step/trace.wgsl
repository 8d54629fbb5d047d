//@ use data/path
//@ use bind/settings
//@ use choice/walk
//@ if alpha
//@ use data/dimension
//@ use scene/coverage
//@ end
// Finds the nearest hit of the path's ray.
fn trace(path: ptr<function, Path>) -> u32 {
    //@ if alpha
    walk_for((*path).pixel, (*path).sample, bounce_dimension((*path).depth, DIMENSION_SCATTER));
    //@ end
    let hit = nearest_hit((*path).ray, settings.root);
    (*path).t = hit.t;
    (*path).status = hit.code;
    //@ if mesh
    (*path).instance = hit.instance;
    //@ end
    return hit.steps;
}

//@ implements mesh_walk when mesh
//@ use data/hit
//@ use data/primitive
//@ use data/ray
//@ use bind/instances
//@ use choice/moved_instance
//@ use geometry/instance
//@ use geometry/slab
//@ use scene/face_pairs
//@ use scene/primitives
// Walks through meshes, which have hierarchies in spaces of their own.

// Enters the mesh whose instance the walk visits. Returns whether it does.
fn enters_mesh(walk: ptr<function, Walk>, pose: Pose, ray: Ray) -> bool {
    if primitive_kind((*walk).code) != KIND_INSTANCE {
        return false;
    }
    let entered = primitive_index((*walk).code);
    (*walk).instance = entered;
    (*walk).entered_at = (*walk).depth;
    (*walk).outside = (*walk).waiting;
    (*walk).waiting = NONE_WAIT;
    (*walk).ray = to_mesh(moved_instance(instances[entered], pose), ray);
    (*walk).inverse = slab_inverse((*walk).ray.direction);
    (*walk).code = instances[entered].root;
    return true;
}

// Leaves the mesh if nothing in it waits.
fn leave_mesh(walk: ptr<function, Walk>, ray: Ray) {
    if (*walk).instance != NO_INSTANCE && (*walk).waiting == NONE_WAIT && (*walk).depth == (*walk).entered_at {
        (*walk).instance = NO_INSTANCE;
        (*walk).ray = ray;
        (*walk).inverse = slab_inverse(ray.direction);
        (*walk).waiting = (*walk).outside;
    }
}

// Where the ray hits the primitive that the walk visits: of a pair of faces, one that is left.
fn hit_of_walk(walk: ptr<function, Walk>, pose: Pose) -> Hit {
    var code = (*walk).code;
    var t = primitive_distance(code, pose, (*walk).ray);
    if primitive_kind(code) == KIND_TRIANGLE {
        let pair = see_pair(primitive_index(code), (*walk).ray, (*walk).inverse, (*walk).tested);
        // Both come before the distance, which is then computed with fewer values in registers (docs/dev/gpu-kernels.md).
        code = code_of_face(pair);
        (*walk).tested = tested_before_other(pair);
        if pair.left != 0u {
            t = hit_of_pair(pair).t;
        }
    }
    var hit = hit_at(code, t);
    hit.instance = (*walk).instance;
    return hit;
}

//@ without
//@ use data/hit
//@ use data/ray
//@ use scene/primitives
// The scene has no meshes.
fn enters_mesh(walk: ptr<function, Walk>, pose: Pose, ray: Ray) -> bool {
    return false;
}

fn leave_mesh(walk: ptr<function, Walk>, ray: Ray) {
}

fn hit_of_walk(walk: ptr<function, Walk>, pose: Pose) -> Hit {
    return hit_at((*walk).code, primitive_distance((*walk).code, pose, (*walk).ray));
}

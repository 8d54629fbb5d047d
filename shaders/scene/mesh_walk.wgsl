//@ implements mesh_walk when mesh
//@ use bind/instances
//@ use geometry/instance
//@ use geometry/slab
//@ use choice/moved_triangle
//@ use scene/face_pairs
//@ use scene/primitives
//@ use scene/walk
// Walks through meshes, each in the space of the mesh.

fn is_mesh(code: u32) -> bool {
    return primitive_kind(code) == KIND_INSTANCE;
}

// Enters the mesh that the walk visits.
fn enter_mesh(walk: ptr<function, Walk>, pose: Pose, ray: Ray) {
    let instance = primitive_index((*walk).code);
    (*walk).instance = instance;
    (*walk).entered_at = (*walk).depth;
    (*walk).outside = (*walk).waiting;
    (*walk).waiting = NONE_WAIT;
    (*walk).ray = to_mesh(moved_instance(instances[instance], pose), ray);
    (*walk).inverse = slab_inverse((*walk).ray.direction);
    (*walk).code = instances[instance].root;
}

// Leaves the mesh if none of its nodes is still to be visited.
fn leave_mesh(walk: ptr<function, Walk>, ray: Ray) {
    if (*walk).instance != NO_INSTANCE && (*walk).waiting == NONE_WAIT && (*walk).depth == (*walk).entered_at {
        (*walk).instance = NO_INSTANCE;
        (*walk).ray = ray;
        (*walk).inverse = slab_inverse(ray.direction);
        (*walk).waiting = (*walk).outside;
    }
}

// Where the ray hits the primitive that the walk visits, or the first face of a pair that is not tested yet.
fn hit_of_walk(walk: ptr<function, Walk>, code: u32, visited: Visited, pose: Pose) -> Hit {
    var candidate = hit_at(code, NO_HIT);
    candidate.instance = (*walk).instance;
    if (*walk).instance != NO_INSTANCE {
        let pair = see_pair(visited_pair(visited), (*walk).ray, (*walk).inverse, (*walk).tested);
        // Both come before the distance, which is then computed with fewer values in registers (docs/dev/gpu-kernels.md).
        candidate.code = code_of_face(pair);
        (*walk).tested = tested_before_other(pair);
        if pair.left != 0u {
            candidate.t = hit_of_pair(pair).t;
        }
    } else {
        candidate.t = primitive_distance(code, pose, (*walk).ray);
    }
    return candidate;
}

//@ without
//@ use scene/primitives
//@ use scene/walk
// There are no meshes.
fn is_mesh(code: u32) -> bool {
    return false;
}

fn enter_mesh(walk: ptr<function, Walk>, pose: Pose, ray: Ray) {}

fn leave_mesh(walk: ptr<function, Walk>, ray: Ray) {}

fn hit_of_walk(walk: ptr<function, Walk>, code: u32, visited: Visited, pose: Pose) -> Hit {
    return hit_at(code, primitive_distance(code, pose, (*walk).ray));
}

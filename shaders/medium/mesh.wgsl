//@ implements medium_in_mesh when boundary.mesh
//@ use bind/instances
//@ use choice/mesh_tree
//@ use choice/moved_triangle
//@ use geometry/bounds
//@ use geometry/instance
//@ use geometry/slab
//@ use medium/interval
//@ use medium/most_steps
//@ use scene/face_pairs
//@ relies on loops
// Media bounded by closed meshes, which a ray may enter and leave any number of times.

// The greatest depth of the stack in the BVH of such a mesh.
const CROSSING_STACK_SIZE: u32 = ${boundary_stack_size}u;
const CHILDREN: u32 = 15u;

// The next crossing after `last`, and the winding number on the part of the ray between them. The winding number is a sum over
// the faces that the ray hits from there to infinity: 1 for each face through which the ray leaves the mesh, and -1 for each
// through which it enters. A ray never slips between the faces of a closed mesh and never hits two of them at once
// (geometry/sheared_triangle), so the sum is right wherever the ray starts.
fn next_crossing(ray: Ray, root: u32, last: Crossing, steps: ptr<function, u32>) -> Crossing {
    let inverse = slab_inverse(ray.direction);
    var next = Crossing(VERY_FAR, 0xffffffffu, 0);
    // The nodes with children that are still to be visited: what names the children above a bit for each of them. The last of them is not on the
    // stack but in `waiting`, and has no bits if none of its children waits.
    var stack: array<u32, CROSSING_STACK_SIZE>;
    var depth = 0u;
    var waiting = 0u;
    // The bit of the face of this pair that the last iteration tested, if this iteration tests the other one.
    var tested = 0u;
    var code = root;
    loop {
        *steps += 1u;
        if *steps >= MOST_STEPS_OF_CROSSINGS {
            break;
        }
        let visited = visit(code);
        if (visited_code(code, visited) & PRIMITIVE_BIT) != 0u {
            let pair = see_pair(visited_pair(visited), ray, inverse, tested);
            if pair.left != 0u {
                let face = primitive_index(code_of_face(pair));
                let hit = hit_of_pair(pair);
                if hit.t > last.t || (hit.t == last.t && face > last.face) {
                    next.winding += select(1, -1, hit.front);
                    if hit.t < next.t || (hit.t == next.t && face < next.face) {
                        next.t = hit.t;
                        next.face = face;
                    }
                }
            }
            tested = tested_before_other(pair);
            if tested != 0u {
                continue;
            }
        } else {
            let keys = child_keys(visited_node(visited), ray.origin, inverse, 0.0, VERY_FAR);
            let bits = select(vec4<u32>(0u), vec4<u32>(1u, 2u, 4u, 8u), keys != vec4<u32>(CHILD_MISSED));
            let children = bits.x | bits.y | bits.z | bits.w;
            if children != 0u {
                if (waiting & CHILDREN) != 0u {
                    stack[depth] = waiting;
                    depth += 1u;
                }
                waiting = children_of(code, visited, true) * 16u + children;
            }
        }
        if (waiting & CHILDREN) == 0u {
            if depth == 0u {
                break;
            }
            depth -= 1u;
            waiting = stack[depth];
        }
        let child = firstLeadingBit(waiting & CHILDREN);
        waiting ^= 1u << child;
        code = child_code(waiting / 16u, child, true);
    }
    return next;
}

// The part of the ray inside the mesh that begins at the last crossing or behind it, up to `limit`; NO_INTERVAL if there is none, and one that
// begins at WALK_CUT if the walk took too many steps. `here` is the ray in the mesh's space.
fn interval_in_mesh(here: Ray, root: u32, last: ptr<function, Crossing>, limit: f32, steps: ptr<function, u32>) -> vec2<f32> {
    // After the last crossing, next_crossing returns the distance VERY_FAR, which ends the loop.
    while (*last).t < limit {
        let begin = (*last).t;
        *last = next_crossing(here, root, *last, steps);
        if *steps >= MOST_STEPS_OF_CROSSINGS {
            return vec2<f32>(WALK_CUT);
        }
        if (*last).winding != 0 {
            return vec2<f32>(begin, min((*last).t, limit));
        }
    }
    return NO_INTERVAL;
}

// That part of a ray in render space.
fn next_in_mesh(ray: Ray, index: u32, pose: Pose, last: ptr<function, Crossing>, limit: f32, steps: ptr<function, u32>) -> vec2<f32> {
    let instance = moved_instance(instances[index], pose);
    return interval_in_mesh(to_mesh(instance, ray), instance.root, last, limit, steps);
}

// The distance at which the ray has travelled the length `distance` inside the mesh, if that is nearer than `limit`; NO_HIT
// otherwise, or WALK_CUT if the walk took too many steps.
fn collision_in_mesh(ray: Ray, index: u32, pose: Pose, distance: f32, limit: f32, steps: ptr<function, u32>) -> f32 {
    let instance = moved_instance(instances[index], pose);
    let here = to_mesh(instance, ray);
    var left = distance;
    var last = AT_ORIGIN;
    var inside = interval_in_mesh(here, instance.root, &last, limit, steps);
    while is_interval(inside) {
        let t = inside.x + left;
        if t < inside.y {
            return t;
        }
        left -= inside.y - inside.x;
        inside = interval_in_mesh(here, instance.root, &last, limit, steps);
    }
    return select(NO_HIT, WALK_CUT, inside.x < 0.0);
}

// The length that the ray travels inside the mesh up to distance t, or WALK_CUT.
fn length_in_mesh(ray: Ray, index: u32, pose: Pose, t: f32, steps: ptr<function, u32>) -> f32 {
    let instance = moved_instance(instances[index], pose);
    let here = to_mesh(instance, ray);
    var distance = 0.0;
    var last = AT_ORIGIN;
    var inside = interval_in_mesh(here, instance.root, &last, t, steps);
    while is_interval(inside) {
        distance += inside.y - inside.x;
        inside = interval_in_mesh(here, instance.root, &last, t, steps);
    }
    return select(distance, WALK_CUT, inside.x < 0.0);
}

//@ without
// No mesh bounds a medium.
fn collision_in_mesh(ray: Ray, index: u32, pose: Pose, distance: f32, limit: f32, steps: ptr<function, u32>) -> f32 {
    return NO_HIT;
}

fn length_in_mesh(ray: Ray, index: u32, pose: Pose, t: f32, steps: ptr<function, u32>) -> f32 {
    return 0.0;
}

fn next_in_mesh(ray: Ray, index: u32, pose: Pose, last: ptr<function, Crossing>, limit: f32, steps: ptr<function, u32>) -> vec2<f32> {
    return NO_INTERVAL;
}

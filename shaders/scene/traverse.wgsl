//@ alternative walk when (mesh | shape | surface) & surface & !brute_force
//@ use choice/mesh_walk
//@ use choice/pose
//@ use scene/primitives
//@ use scene/walk
//@ use choice/stops
//@ use choice/passed_panes
//@ relies on loops
// Finds the nearest primitive along a ray.

// Mesa 22.3 silently ends all loops of an invocation after 65,535 iterations. This limit leaves room for the other loops
// (stage/bounce). A walk takes this many steps only among tens of thousands of objects that overlap. Its path is then rejected
// and counted. The limit is higher if the numerics probe finds no limit on loops.
override MOST_STEPS_OF_WALK: u32 = ${most_steps}u;

// The nearest hit with t > 0 that is not beyond `limit`; with `any_will_do`, the first such hit found. There is no minimum
// distance, because rays start with an offset from the surface that they leave. Of two hits at the same distance, the primitive
// that comes first in the scene wins, so the order of the walk does not change the image.
fn first_hit(ray: Ray, root: u32, limit: Hit, any_will_do: bool) -> Hit {
    var hit = limit;
    if root == HIT_NOTHING {
        return hit;
    }
    var walk: Walk;
    var stack: array<u32, STACK_SIZE>;
    start_walk(&walk, ray, root);
    loop {
        if hit.steps >= MOST_STEPS_OF_WALK {
            hit.code = PATH_CUT;
            break;
        }
        hit.steps += 1u;
        var next = CHILD_MISSED;
        let visited = visit(walk.code);
        let code = visited_code(walk.code, visited);
        if (code & PRIMITIVE_BIT) != 0u {
            let pose = pose_at(code, NO_INSTANCE);
            if is_mesh(code) {
                enter_mesh(&walk, pose, ray);
                continue;
            }
            var candidate = hit_of_walk(&walk, code, visited, pose);
            candidate.t = distance_ahead(candidate, pose, walk.ray);
            if candidate.t != NO_HIT && candidate.t <= hit.t {
                if (candidate.t < hit.t || comes_before(candidate, hit)) && stops_before(&candidate, hit, pose, ray) {
                    candidate.steps = hit.steps;
                    hit = candidate;
                    if any_will_do && may_end_walk(candidate) {
                        break;
                    }
                }
            }
            if walk.tested != 0u {
                continue;
            }
        } else {
            next = nearest_child(&walk, &stack, visited, hit.t);
        }
        if next == CHILD_MISSED {
            leave_mesh(&walk, ray);
            if walk.waiting == NONE_WAIT {
                if walk.depth == 0u {
                    break;
                }
                walk.depth -= 1u;
                walk.waiting = stack[walk.depth];
            }
            next = take_waiting(&walk);
        }
        walk.code = child_code(next / 4u, next % 4u, walk.instance != NO_INSTANCE);
    }
    return hit;
}

fn nearest_hit(ray: Ray, root: u32) -> Hit {
    return first_hit(ray, root, hit_at(HIT_NOTHING, VERY_FAR), false);
}

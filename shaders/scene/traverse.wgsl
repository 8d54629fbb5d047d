//@ alternative walk when (mesh | shape | surface) & surface & !brute_force
//@ use data/ray
//@ use data/surface
//@ use data/hit
//@ use data/primitive
//@ use bind/nodes
//@ use geometry/bounds
//@ use scene/primitives
//@ use choice/mesh_walk
//@ use choice/stops
//@ use choice/passed_panes
//@ use lib/float
//@ relies on loops
// Finds the nearest primitive along a ray.

// The greatest depth of the stack in this scene's BVH. It is filled in as text, because an override cannot be the
// size of a private array in WGSL.
const STACK_SIZE: u32 = ${stack_size}u;

// Mesa 22.3 silently ends all loops of an invocation after 65,535 iterations. This limit leaves room for the other loops
// (stage/bounce). A walk takes this many steps only among tens of thousands of objects that overlap. Its path is then rejected
// and counted. The limit is higher if the numerics probe finds no limit on loops.
override MOST_STEPS_OF_WALK: u32 = ${most_steps}u;

// The waiting children of a node, in one word: the node's index above three numbers of two bits, the nearest child lowest. The last
// number is repeated if fewer than three wait.
const WAITING_BITS: u32 = 6u;
const NONE_WAIT: u32 = 0xffffffffu;

// A walk: where it is, and what is still to be visited.
struct Walk {
    // The node or the primitive that it visits.
    code: u32,
    // The ray in the space of the current nodes: the scene's space, or that of the mesh that the walk has entered.
    ray: Ray,
    inverse: vec3<f32>,
    // The nodes with children that are still to be visited. The last of them is not on the stack but in `waiting`.
    stack: array<u32, STACK_SIZE>,
    depth: u32,
    waiting: u32,
    // The instance of the mesh that it has entered, and the stack's depth and what was on top of it there.
    instance: u32,
    entered_at: u32,
    outside: u32,
    // The bit of the face of this pair that the last iteration tested, if this iteration tests the other one.
    tested: u32,
}

fn start_walk(ray: Ray, root: u32) -> Walk {
    var walk: Walk;
    walk.code = root;
    walk.ray = ray;
    walk.inverse = slab_inverse(ray.direction);
    walk.waiting = NONE_WAIT;
    walk.instance = NO_INSTANCE;
    return walk;
}

// The word for the children with these keys. The first one is not CHILD_MISSED.
fn wait_for(code: u32, keys: vec3<u32>) -> u32 {
    let second = select(keys.y, keys.x, keys.y == CHILD_MISSED);
    let third = select(keys.z, second, keys.z == CHILD_MISSED);
    let numbers = vec3<u32>(keys.x, second, third) & vec3<u32>(CHILD_MASK);
    return (code << WAITING_BITS) | (numbers.z << 4u) | (numbers.y << 2u) | numbers.x;
}

// The nearest child of the walk's node that the ray may hit before `nearest`, or CHILD_MISSED. The others wait.
fn nearest_child(walk: ptr<function, Walk>, nearest: f32) -> u32 {
    let code = (*walk).code;
    let keys = sort_keys(child_keys(nodes[code], (*walk).ray.origin, (*walk).inverse, begin_of_walk(), nearest));
    if keys.y != CHILD_MISSED {
        if (*walk).waiting != NONE_WAIT {
            (*walk).stack[(*walk).depth] = (*walk).waiting;
            (*walk).depth += 1u;
        }
        (*walk).waiting = wait_for(code, keys.yzw);
    }
    return select(code * 4u + (keys.x & CHILD_MASK), CHILD_MISSED, keys.x == CHILD_MISSED);
}

// The next child that waits, or CHILD_MISSED if none does.
fn next_waiting(walk: ptr<function, Walk>) -> u32 {
    if (*walk).waiting == NONE_WAIT {
        if (*walk).depth == 0u {
            return CHILD_MISSED;
        }
        (*walk).depth -= 1u;
        (*walk).waiting = (*walk).stack[(*walk).depth];
    }
    let waiting = (*walk).waiting;
    let child = waiting & CHILD_MASK;
    let after = (waiting >> 2u) & CHILD_MASK;
    // The next child moves to the lowest bits, and the last one is repeated.
    let rest = (waiting & ~15u) | ((waiting >> 2u) & 15u);
    (*walk).waiting = select(rest, NONE_WAIT, after == child);
    return (waiting >> WAITING_BITS) * 4u + child;
}

// The nearest hit with t > 0 that is not beyond `limit`; with `any_will_do`, the first such hit found. There is no minimum
// distance, because rays start with an offset from the surface that they leave. Of two hits at the same distance, the primitive
// that comes first in the scene wins, so the order of the walk does not change the image.
fn first_hit(ray: Ray, root: u32, limit: Hit, any_will_do: bool) -> Hit {
    var hit = limit;
    if root == HIT_NOTHING {
        return hit;
    }
    var walk = start_walk(ray, root);
    loop {
        if hit.steps >= MOST_STEPS_OF_WALK {
            hit.code = PATH_CUT;
            break;
        }
        hit.steps += 1u;
        var next = CHILD_MISSED;
        if (walk.code & PRIMITIVE_BIT) != 0u {
            let pose = pose_at(walk.code, NO_INSTANCE);
            if enters_mesh(&walk, pose, ray) {
                continue;
            }
            var candidate = hit_of_walk(&walk, pose);
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
            next = nearest_child(&walk, hit.t);
        }
        if next == CHILD_MISSED {
            leave_mesh(&walk, ray);
            next = next_waiting(&walk);
            if next == CHILD_MISSED {
                break;
            }
        }
        walk.code = nodes[next / 4u].children[next % 4u];
    }
    return hit;
}

fn nearest_hit(ray: Ray, root: u32) -> Hit {
    return first_hit(ray, root, hit_at(HIT_NOTHING, VERY_FAR), false);
}

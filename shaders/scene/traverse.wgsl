//@ alternative walk when (mesh | shape | surface) & surface & !brute_force
//@ use data/ray
//@ use data/surface
//@ use data/hit
//@ use data/primitive
//@ use bind/nodes
//@ use geometry/bounds
//@ use scene/primitives
//@ if mesh
//@ use geometry/instance
//@ use choice/moved_instance
//@ use scene/face_pairs
//@ end
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

// The word for the children with these keys. The first one is not CHILD_MISSED.
fn wait_for(code: u32, keys: vec3<u32>) -> u32 {
    let second = select(keys.y, keys.x, keys.y == CHILD_MISSED);
    let third = select(keys.z, second, keys.z == CHILD_MISSED);
    let numbers = vec3<u32>(keys.x, second, third) & vec3<u32>(CHILD_MASK);
    return (code << WAITING_BITS) | (numbers.z << 4u) | (numbers.y << 2u) | numbers.x;
}

// The nearest hit with t > 0 that is not beyond `limit`; with `any_will_do`, the first such hit found. There is no minimum
// distance, because rays start with an offset from the surface that they leave. Of two hits at the same distance, the primitive
// that comes first in the scene wins, so the order of the walk does not change the image.
fn first_hit(ray: Ray, root: u32, limit: Hit, any_will_do: bool) -> Hit {
    var hit = limit;
    if root == HIT_NOTHING {
        return hit;
    }
    // The ray in the space of the current nodes: the scene's space, or that of the mesh that the walk has entered.
    var here = ray;
    var inverse = slab_inverse(ray.direction);
    //@ if mesh
    var instance = NO_INSTANCE;
    // The bit of the face of this pair that the last iteration tested, if this iteration tests the other one.
    var tested = 0u;
    // The stack's depth and what was on top of it when the mesh was entered.
    var entered_at = 0u;
    var outside = NONE_WAIT;
    //@ end
    // The nodes with children that are still to be visited. The last of them is not on the stack but in `waiting`.
    var stack: array<u32, STACK_SIZE>;
    var depth = 0u;
    var waiting = NONE_WAIT;
    var code = root;
    loop {
        if hit.steps >= MOST_STEPS_OF_WALK {
            hit.code = PATH_CUT;
            break;
        }
        hit.steps += 1u;
        var next = CHILD_MISSED;
        if (code & PRIMITIVE_BIT) != 0u {
            let pose = pose_at(code, NO_INSTANCE);
            //@ if mesh
            if primitive_kind(code) == KIND_INSTANCE {
                let entered = primitive_index(code);
                instance = entered;
                entered_at = depth;
                outside = waiting;
                waiting = NONE_WAIT;
                here = to_mesh(moved_instance(instances[entered], pose), ray);
                inverse = slab_inverse(here.direction);
                code = instances[entered].root;
                continue;
            }
            //@ end
            var t = primitive_distance(code, pose, here);
            //@ if mesh
            let leaf = code;
            if primitive_kind(leaf) == KIND_TRIANGLE {
                let pair = see_pair(primitive_index(leaf), here, inverse, tested);
                // Both come before the distance, which is then computed with fewer values in registers (docs/dev/gpu-kernels.md).
                code = code_of_face(pair);
                tested = tested_before_other(pair);
                if pair.left != 0u {
                    t = hit_of_pair(pair).t;
                }
            }
            //@ end
            var candidate = hit_at(code, t);
            //@ if mesh
            candidate.instance = instance;
            //@ end
            candidate.t = distance_ahead(candidate, pose, here);
            if candidate.t != NO_HIT && candidate.t <= hit.t {
                if (candidate.t < hit.t || comes_before(candidate, hit)) && stops_before(&candidate, hit, pose, ray) {
                    candidate.steps = hit.steps;
                    hit = candidate;
                    if any_will_do && may_end_walk(candidate) {
                        break;
                    }
                }
            }
            //@ if mesh
            if tested != 0u {
                code = leaf;
                continue;
            }
            //@ end
        } else {
            let keys = sort_keys(child_keys(nodes[code], here.origin, inverse, begin_of_walk(), hit.t));
            if keys.y != CHILD_MISSED {
                if waiting != NONE_WAIT {
                    stack[depth] = waiting;
                    depth += 1u;
                }
                waiting = wait_for(code, keys.yzw);
            }
            next = select(code * 4u + (keys.x & CHILD_MASK), CHILD_MISSED, keys.x == CHILD_MISSED);
        }
        if next == CHILD_MISSED {
            //@ if mesh
            if instance != NO_INSTANCE && waiting == NONE_WAIT && depth == entered_at {
                instance = NO_INSTANCE;
                here = ray;
                inverse = slab_inverse(ray.direction);
                waiting = outside;
            }
            //@ end
            if waiting == NONE_WAIT {
                if depth == 0u {
                    break;
                }
                depth -= 1u;
                waiting = stack[depth];
            }
            let child = waiting & CHILD_MASK;
            next = (waiting >> WAITING_BITS) * 4u + child;
            let after = (waiting >> 2u) & CHILD_MASK;
            // The next child moves to the lowest bits, and the last one is repeated.
            let rest = (waiting & ~15u) | ((waiting >> 2u) & 15u);
            waiting = select(rest, NONE_WAIT, after == child);
        }
        code = nodes[next / 4u].children[next % 4u];
    }
    return hit;
}

fn nearest_hit(ray: Ray, root: u32) -> Hit {
    return first_hit(ray, root, hit_at(HIT_NOTHING, VERY_FAR), false);
}

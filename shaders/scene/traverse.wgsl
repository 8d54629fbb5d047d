//@ use data/ray
//@ use data/surface
//@ use data/hit
//@ use data/primitive
//@ use bind/nodes
//@ use geometry/bounds
//@ use scene/primitives
//@ if mesh
//@ use geometry/instance
//@ end
//@ use lib/float
//@ relies on loops
// Finds the nearest primitive along a ray.

// The greatest depth of the stack in this scene's BVH. It is filled in as text, because an override cannot be the
// size of a private array in WGSL.
const STACK_SIZE: u32 = ${stack_size}u;

// Mesa 22.3 silently ends all loops of an invocation after 65,535 iterations. This limit leaves room for the other loops
// (stage/bounce). A walk takes this many steps only among tens of thousands of objects in one place. Its path is then rejected
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
    // The ray in the space of the current nodes: the scene's space, or that of the mesh that the walk has entered.
    var here = ray;
    var inverse = slab_inverse(ray.direction);
    //@ if mesh
    var instance = NO_INSTANCE;
    // The stack's depth when the mesh was entered.
    var entered_at = 0u;
    //@ end
    // The children that are still to be visited: the node's index times four, plus the child's number.
    var stack: array<u32, STACK_SIZE>;
    var depth = 0u;
    var code = root;
    loop {
        if hit.steps == MOST_STEPS_OF_WALK {
            hit.code = PATH_CUT;
            break;
        }
        hit.steps += 1u;
        var next = CHILD_MISSED;
        if (code & PRIMITIVE_BIT) != 0u {
            //@ if mesh
            if primitive_kind(code) == KIND_INSTANCE {
                let entered = primitive_index(code);
                instance = entered;
                entered_at = depth;
                here = to_mesh(instances[entered], ray);
                inverse = slab_inverse(here.direction);
                code = instances[entered].root;
                continue;
            }
            //@ end
            let t = primitive_distance(code, here, inverse);
            if t != NO_HIT && t <= hit.t {
                var candidate = hit_at(code, t);
                //@ if mesh
                candidate.instance = instance;
                //@ end
                if t < hit.t || comes_before(candidate, hit) {
                    candidate.steps = hit.steps;
                    hit = candidate;
                    if any_will_do {
                        break;
                    }
                }
            }
        } else {
            let keys = sort_keys(child_keys(nodes[code], here.origin, inverse, hit.t));
            // The farther children wait on the stack. All three are written, but `depth` only counts those that the ray may hit.
            stack[depth] = code * 4u + (keys.w & CHILD_MASK);
            depth += u32(keys.w != CHILD_MISSED);
            stack[depth] = code * 4u + (keys.z & CHILD_MASK);
            depth += u32(keys.z != CHILD_MISSED);
            stack[depth] = code * 4u + (keys.y & CHILD_MASK);
            depth += u32(keys.y != CHILD_MISSED);
            next = select(code * 4u + (keys.x & CHILD_MASK), CHILD_MISSED, keys.x == CHILD_MISSED);
        }
        if next == CHILD_MISSED {
            //@ if mesh
            if instance != NO_INSTANCE && depth == entered_at {
                instance = NO_INSTANCE;
                here = ray;
                inverse = slab_inverse(ray.direction);
            }
            //@ end
            if depth == 0u {
                break;
            }
            depth -= 1u;
            next = stack[depth];
        }
        code = nodes[next / 4u].children[next % 4u];
    }
    return hit;
}

fn nearest_hit(ray: Ray, root: u32) -> Hit {
    return first_hit(ray, root, hit_at(HIT_NOTHING, VERY_FAR), false);
}

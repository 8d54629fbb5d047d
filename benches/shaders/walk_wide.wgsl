//@ use bench/mesh
//@ use geometry/slab
//@ use geometry/bounds
//@ use choice/keys
// Nodes of four children, walked as scene/traverse does it.
const STACK_SIZE: u32 = ${stack_size}u;

fn walk(ray: Ray) -> Found {
    let inverse = slab_inverse(ray.direction);
    var found = Found(VERY_FAR, NO_TRIANGLE, 0u);
    var stack: array<u32, STACK_SIZE>;
    var depth = 0u;
    var code = 0u;
    loop {
        found.steps += 1u;
        var next = CHILD_MISSED;
        if (code & LEAF_BIT) != 0u {
            meet_leaf(code, ray, &found);
        } else {
            let keys = sort_keys(keys_of(code, ray.origin, inverse, found.t));
            stack[depth] = code * 4u + (keys.w & CHILD_MASK);
            depth += u32(keys.w != CHILD_MISSED);
            stack[depth] = code * 4u + (keys.z & CHILD_MASK);
            depth += u32(keys.z != CHILD_MISSED);
            stack[depth] = code * 4u + (keys.y & CHILD_MASK);
            depth += u32(keys.y != CHILD_MISSED);
            next = select(code * 4u + (keys.x & CHILD_MASK), CHILD_MISSED, keys.x == CHILD_MISSED);
        }
        if next == CHILD_MISSED {
            if depth == 0u {
                break;
            }
            depth -= 1u;
            next = stack[depth];
        }
        code = nodes[next / 4u].children[next % 4u];
    }
    return found;
}

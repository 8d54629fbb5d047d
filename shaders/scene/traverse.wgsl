//@ use data/ray
//@ use data/hit
//@ use data/primitive
//@ use bind/nodes
//@ use geometry/bounds
//@ use scene/primitives
//@ use lib/float
// The nearest primitive along a ray.

struct Hit {
    code: u32,
    t: f32,
}

// The deepest the stack can get: the depth of this scene's BVH. A text constant, since WGSL sizes no private array by an
// override.
const STACK_SIZE: u32 = ${stack_size}u;

// Nearest hit with t > 0. There is no least distance: rays start off the surfaces that they leave. Of two hits at one
// distance the primitive that comes first in the scene wins, so that the order of the walk cannot show.
fn nearest_hit(ray: Ray, root: u32) -> Hit {
    var hit = Hit(HIT_NOTHING, VERY_FAR);
    if root == HIT_NOTHING {
        return hit;
    }
    let inverse = slab_inverse(ray.direction);
    var stack: array<u32, STACK_SIZE>;
    var depth = 0u;
    var code = root;
    loop {
        if (code & PRIMITIVE_BIT) != 0u {
            let t = primitive_distance(code, ray);
            if t != NO_HIT && t <= hit.t {
                if t < hit.t || primitive_order(code) < primitive_order(hit.code) {
                    hit = Hit(code, t);
                }
            }
            if depth == 0u {
                break;
            }
            depth -= 1u;
            code = stack[depth];
        } else {
            let node = nodes[code];
            let left = box_entry(ray.origin, inverse, node.left_min, node.left_max, hit.t);
            let right = box_entry(ray.origin, inverse, node.right_min, node.right_max, hit.t);
            let nearer = select(node.right, node.left, left <= right);
            let farther = select(node.left, node.right, left <= right);
            if min(left, right) != BOX_MISSED {
                if max(left, right) != BOX_MISSED {
                    stack[depth] = farther;
                    depth += 1u;
                }
                code = nearer;
            } else {
                if depth == 0u {
                    break;
                }
                depth -= 1u;
                code = stack[depth];
            }
        }
    }
    return hit;
}

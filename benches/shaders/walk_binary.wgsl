//@ use bench/mesh
//@ use geometry/slab
// A binary tree with f32 boxes: a node holds those of its two children.
struct Node {
    low0: vec3<f32>,
    code0: u32,
    high0: vec3<f32>,
    code1: u32,
    low1: vec3<f32>,
    padding0: u32,
    high1: vec3<f32>,
    padding1: u32,
}

@group(0) @binding(3) var<storage, read> nodes: array<Node>;

const STACK_SIZE: u32 = ${stack_size}u;

// Where the ray enters a box; VERY_FAR where it does not before `nearest`.
fn entry(low: vec3<f32>, high: vec3<f32>, ray: Ray, inverse: vec3<f32>, nearest: f32) -> f32 {
    let planes = slab(ray.origin, inverse, low, high);
    let enter = max(max(planes.enter.x, planes.enter.y), max(planes.enter.z, 0.0));
    let leave = min(min(planes.leave.x, planes.leave.y), planes.leave.z) * (1.0 + 8.0 * UNIT_ROUNDOFF);
    return select(VERY_FAR, enter, enter <= min(leave, nearest));
}

fn walk(ray: Ray) -> Found {
    let inverse = slab_inverse(ray.direction);
    var found = Found(VERY_FAR, NO_TRIANGLE, 0u);
    var stack: array<u32, STACK_SIZE>;
    var depth = 0u;
    var code = 0u;
    loop {
        found.steps += 1u;
        var descends = false;
        if (code & LEAF_BIT) != 0u {
            meet_leaf(code, ray, &found);
        } else {
            let node = nodes[code];
            let t0 = entry(node.low0, node.high0, ray, inverse, found.t);
            let t1 = entry(node.low1, node.high1, ray, inverse, found.t);
            stack[depth] = select(node.code0, node.code1, t0 <= t1);
            depth += u32(max(t0, t1) < VERY_FAR);
            code = select(node.code1, node.code0, t0 <= t1);
            descends = min(t0, t1) < VERY_FAR;
        }
        if !descends {
            if depth == 0u {
                break;
            }
            depth -= 1u;
            code = stack[depth];
        }
    }
    return found;
}

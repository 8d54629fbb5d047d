//@ use geometry/bounds
// A ray against the children of a BVH node.
struct In {
    origin: vec3<f32>,
    nearest: f32,
    direction: vec3<f32>,
    node: u32,
    begin: f32,
    padding0: f32,
    padding1: f32,
    padding2: f32,
}

struct Out {
    keys: vec4<u32>,
    sorted: vec4<u32>,
}

@group(0) @binding(23) var<storage, read> nodes: array<Node>;

fn run(row: u32) {
    let given = input[row];
    let keys = child_keys(nodes[given.node], given.origin, slab_inverse(given.direction), given.begin, given.nearest);
    output[row] = Out(keys, sort_keys(keys));
}

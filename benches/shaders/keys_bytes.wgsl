//@ use data/primitive
//@ use geometry/bounds
// The production nodes.
@group(0) @binding(3) var<storage, read> nodes: array<Node>;

fn keys_of(code: u32, origin: vec3<f32>, inverse: vec3<f32>, nearest: f32) -> vec4<u32> {
    return child_keys(nodes[code], origin, inverse, nearest);
}

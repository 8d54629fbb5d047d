//@ use geometry/bounds
// Four boxes of f32 a node.
struct WideNode {
    low_x: vec4<f32>,
    low_y: vec4<f32>,
    low_z: vec4<f32>,
    high_x: vec4<f32>,
    high_y: vec4<f32>,
    high_z: vec4<f32>,
    children: vec4<u32>,
}

@group(0) @binding(3) var<storage, read> nodes: array<WideNode>;

fn keys_of(code: u32, origin: vec3<f32>, inverse: vec3<f32>, nearest: f32) -> vec4<u32> {
    let node = nodes[code];
    let x0 = (node.low_x - origin.x) * inverse.x;
    let x1 = (node.high_x - origin.x) * inverse.x;
    let y0 = (node.low_y - origin.y) * inverse.y;
    let y1 = (node.high_y - origin.y) * inverse.y;
    let z0 = (node.low_z - origin.z) * inverse.z;
    let z1 = (node.high_z - origin.z) * inverse.z;
    let enter = max(max(min(x0, x1), min(y0, y1)), max(min(z0, z1), vec4<f32>(0.0)));
    let leave = min(min(max(x0, x1), max(y0, y1)), max(z0, z1)) * (1.0 + 8.0 * UNIT_ROUNDOFF);
    let child = vec4<u32>(0u, 1u, 2u, 3u);
    // A child that is not there has its lower planes above the upper ones, beyond all others.
    let met = enter <= min(leave, vec4<f32>(nearest)) & node.low_x <= node.high_x;
    let key = (bitcast<vec4<u32>>(enter) & vec4<u32>(~CHILD_MASK)) | child;
    return select(vec4<u32>(CHILD_MISSED), key, met);
}

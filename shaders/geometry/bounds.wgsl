//@ use data/primitive
//@ use geometry/slab
// Which children of a BVH node a ray may meet nearer than `nearest`; never a false no.

const CHILD_MISSED: u32 = 0xffffffffu;
const CHILD_MASK: u32 = 3u;

// The four bytes of a word, the lowest first.
fn bytes_of(word: u32) -> vec4<f32> {
    return vec4<f32>((vec4<u32>(word) >> vec4<u32>(0u, 8u, 16u, 24u)) & vec4<u32>(255u));
}

// The distances to planes of the node's grid along one axis. The byte times the scale is exact, so that the sum is rounded
// once, whether or not the driver fuses the two.
fn plane_distances(planes: u32, origin: f32, scale: f32, ray_origin: f32, inverse: f32) -> vec4<f32> {
    return (bytes_of(planes) * scale + origin - ray_origin) * inverse;
}

// A key for each child that the ray may meet, else CHILD_MISSED: the bits of the distance at which it enters the box (0
// from inside), which sort as the distances do, with the child's number in place of the last two.
// Leaving is moved out beyond the error of the slab test: 2 gamma(3) by Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013,
// with 2.5 ulps for the reciprocal instead of half of one.
fn child_keys(node: Node, origin: vec3<f32>, inverse: vec3<f32>, nearest: f32) -> vec4<u32> {
    let exponents = (vec3<u32>(node.exponents) >> vec3<u32>(0u, 8u, 16u)) & vec3<u32>(255u);
    let scale = bitcast<vec3<f32>>(exponents << vec3<u32>(23u));
    let forward = inverse >= vec3<f32>(0.0);
    let near = select(node.high, node.low, forward);
    let far = select(node.low, node.high, forward);
    let enter_x = plane_distances(near.x, node.origin.x, scale.x, origin.x, inverse.x);
    let enter_y = plane_distances(near.y, node.origin.y, scale.y, origin.y, inverse.y);
    let enter_z = plane_distances(near.z, node.origin.z, scale.z, origin.z, inverse.z);
    let leave_x = plane_distances(far.x, node.origin.x, scale.x, origin.x, inverse.x);
    let leave_y = plane_distances(far.y, node.origin.y, scale.y, origin.y, inverse.y);
    let leave_z = plane_distances(far.z, node.origin.z, scale.z, origin.z, inverse.z);
    let enter = max(max(enter_x, enter_y), max(enter_z, vec4<f32>(0.0)));
    let leave = min(min(leave_x, leave_y), leave_z) * 1.000001;
    let child = vec4<u32>(0u, 1u, 2u, 3u);
    let met = enter <= min(leave, vec4<f32>(nearest)) & child < vec4<u32>(node.exponents >> 24u);
    let key = (bitcast<vec4<u32>>(enter) & vec4<u32>(~CHILD_MASK)) | child;
    return select(vec4<u32>(CHILD_MISSED), key, met);
}

// Sorts four keys, the smallest first: a network of five exchanges.
fn sort_keys(keys: vec4<u32>) -> vec4<u32> {
    let low = min(keys.xz, keys.yw);
    let high = max(keys.xz, keys.yw);
    let middle = vec2<u32>(max(low.x, low.y), min(high.x, high.y));
    return vec4<u32>(min(low.x, low.y), min(middle.x, middle.y), max(middle.x, middle.y), max(high.x, high.y));
}

//@ use geometry/slab
// Finds the children of a BVH node that a ray may hit from the distance `begin` to `nearest`. The test is conservative: it never
// rejects a child that the ray hits.

const CHILD_MISSED: u32 = 0xffffffffu;
const CHILD_MASK: u32 = 3u;

// The four bytes of a word, the lowest first.
fn bytes_of(word: u32) -> vec4<f32> {
    return vec4<f32>((vec4<u32>(word) >> vec4<u32>(0u, 8u, 16u, 24u)) & vec4<u32>(255u));
}

// The node's grid along one axis: the ray reaches the plane of byte b at the distance b * step + start, with an error below `error`.
struct GridAxis {
    step: f32,
    start: f32,
    error: f32,
}

// An axis with planes that are farther than this rejects no child, because the distances could overflow.
const FARTHEST_PLANE: f32 = 0x1p120f;

// The bound of the rounding error: the difference, the reciprocal's 2.5 ulps counted twice (the reciprocal scales both terms),
// the products and the sum add up to less than eight roundings of the largest possible term.
fn grid_axis(origin: f32, exponent: u32, ray_origin: f32, inverse: f32) -> GridAxis {
    let step = bitcast<f32>(exponent << 23u) * inverse;
    let start = (origin - ray_origin) * inverse;
    let farthest = abs(start) + 255.0 * abs(step);
    let is_near = farthest < FARTHEST_PLANE;
    let error = select(VERY_FAR, 8.0 * UNIT_ROUNDOFF * farthest, is_near);
    return GridAxis(select(0.0, step, is_near), select(0.0, start, is_near), error);
}

// The bits of the distances to four planes, as integers. Floats that are not negative have the same order as their bits. A negative float
// has negative bits. So the largest integer, with 0 among them, belongs to the largest float, and the least one is negative if a float
// is. Integers are compared faster, because Mesa's software driver tests floats for NaN.
fn enter_axis(axis: GridAxis, planes: u32) -> vec4<i32> {
    return bitcast<vec4<i32>>(bytes_of(planes) * axis.step + (axis.start - axis.error));
}

fn leave_axis(axis: GridAxis, planes: u32) -> vec4<i32> {
    return bitcast<vec4<i32>>(bytes_of(planes) * axis.step + (axis.start + axis.error));
}

// A key for each child that the ray may hit, and CHILD_MISSED for the others. A key holds the bits of the distance at which the ray
// enters the box (`begin` from inside), with the child's number in place of the last two bits. Keys sort in the order of the distances.
fn child_keys(node: Node, origin: vec3<f32>, inverse: vec3<f32>, begin: f32, nearest: f32) -> vec4<u32> {
    let grid_origin = bitcast<vec3<f32>>(node.grid.xyz);
    let exponents = (vec3<u32>(node.grid.w) >> vec3<u32>(0u, 8u, 16u)) & vec3<u32>(255u);
    let x = grid_axis(grid_origin.x, exponents.x, origin.x, inverse.x);
    let y = grid_axis(grid_origin.y, exponents.y, origin.y, inverse.y);
    let z = grid_axis(grid_origin.z, exponents.z, origin.z, inverse.z);
    let forward = inverse >= vec3<f32>(0.0);
    let near = select(node.high, node.low, forward);
    let far = select(node.low, node.high, forward);
    let enter_yz = max(enter_axis(y, near.y), enter_axis(z, near.z));
    let leave_yz = min(leave_axis(y, far.y), leave_axis(z, far.z));
    let enter = max(max(enter_axis(x, near.x), enter_yz), vec4<i32>(bitcast<i32>(begin)));
    let leave = min(min(leave_axis(x, far.x), leave_yz), vec4<i32>(bitcast<i32>(nearest)));
    let child = vec4<u32>(0u, 1u, 2u, 3u);
    // Compared as floats, among which -0 equals 0.
    let is_there = child < vec4<u32>(node.grid.w >> 24u);
    let is_hit = (bitcast<vec4<f32>>(enter) <= bitcast<vec4<f32>>(leave)) & is_there;
    let key = (bitcast<vec4<u32>>(enter) & vec4<u32>(~CHILD_MASK)) | child;
    return select(vec4<u32>(CHILD_MISSED), key, is_hit);
}

// The four keys in ascending order, by a sorting network of five exchanges.
fn sort_keys(keys: vec4<u32>) -> vec4<u32> {
    let low = min(keys.xz, keys.yw);
    let high = max(keys.xz, keys.yw);
    let middle = vec2<u32>(max(low.x, low.y), min(high.x, high.y));
    return vec4<u32>(min(low.x, low.y), min(middle.x, middle.y), max(middle.x, middle.y), max(high.x, high.y));
}

//@ use choice/close_signs
// Intersects rays with triangles, without gaps: no ray passes between triangles that share an edge or a vertex, and none hits
// two of them there. The vertices are sheared so that the ray runs along z. Three edge functions show on which sides of the
// edges the origin of the x, y plane lies (Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013).
// Here the signs of the edge functions are exact for the sheared vertices, however a driver rounds or fuses. They are never 0,
// because the origin is treated as if moved by an infinitesimal (Edelsbrunner and Mücke, "Simulation of Simplicity", ACM TOG
// 9(1), 1990). A sheared vertex depends only on the ray and the vertex, so the results for neighbouring triangles are
// consistent. This holds for coordinates below 2^62 relative to the ray's origin.

struct TriangleHit {
    // NO_HIT, or the distance, above 0, in units of the direction's length.
    t: f32,
    // The ray comes from the side on which a, b, c run counter-clockwise.
    front: bool,
    // Weights of a, b and c, none negative; their sum is 1.
    barycentric: vec3<f32>,
}

// The part of the test that all triangles share for one ray.
struct Shear {
    // The axis of the direction's largest component: 0, 1 or 2 for x, y or z. It becomes z.
    axis: u32,
    // The ray's origin with its components in the new order.
    origin: vec3<f32>,
    // d.x / d.z and d.y / d.z in the new order, and 1 / d.z.
    slope: vec3<f32>,
}

// The components in cyclic order, with that of the axis last. This preserves handedness.
fn end_with_axis(v: vec3<f32>, axis: u32) -> vec3<f32> {
    return select(select(v, v.zxy, axis == 1u), v.yzx, axis == 0u);
}

// `inverse` is slab_inverse(ray.direction).
fn shear_along(ray: Ray, inverse: vec3<f32>) -> Shear {
    let size = abs(ray.direction);
    let axis = select(select(2u, 1u, size.y >= size.z), 0u, size.x >= size.y && size.x >= size.z);
    let direction = end_with_axis(ray.direction, axis);
    let over_z = end_with_axis(inverse, axis).z;
    return Shear(axis, end_with_axis(ray.origin, axis), vec3<f32>(direction.xy * over_z, over_z));
}

// Components below 2^-60 become 0, so that no product of two is subnormal and flushed.
fn flush_small(v: vec4<f32>) -> vec4<f32> {
    return select(v, vec4<f32>(0.0), abs(v) < vec4<f32>(0x1p-60f));
}

// Four points, sheared so that the ray runs along z from the origin.
struct SeenCorners {
    x: vec4<f32>,
    y: vec4<f32>,
    z: vec4<f32>,
}

fn see_corners(shear: Shear, a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, d: vec3<f32>) -> SeenCorners {
    let from_a = end_with_axis(a, shear.axis) - shear.origin;
    let from_b = end_with_axis(b, shear.axis) - shear.origin;
    let from_c = end_with_axis(c, shear.axis) - shear.origin;
    let from_d = end_with_axis(d, shear.axis) - shear.origin;
    // One expression for all points, so that a vertex goes through the same operations in every triangle.
    let z = vec4<f32>(from_a.z, from_b.z, from_c.z, from_d.z);
    let x = flush_small(vec4<f32>(from_a.x, from_b.x, from_c.x, from_d.x) - shear.slope.x * z);
    let y = flush_small(vec4<f32>(from_a.y, from_b.y, from_c.y, from_d.y) - shear.slope.y * z);
    return SeenCorners(x, y, z);
}

// The components in cyclic order, starting with x, y or z for a shift of 0, 1 or 2.
fn cyclic(v: vec3<f32>, shift: u32) -> vec3<f32> {
    return select(select(v, v.yzx, shift == 1u), v.zxy, shift == 2u);
}

fn index_of_least(v: vec3<f32>) -> u32 {
    return select(select(2u, 1u, v.y <= v.z), 0u, v.x <= v.y && v.x <= v.z);
}

// Twice the signed areas of the three triangles that the origin forms with the edges opposite to a, b, c.
struct Areas {
    areas: vec3<f32>,
    // Whether the sign is that of the exact area.
    certain: vec3<bool>,
}

fn areas_of(x: vec3<f32>, y: vec3<f32>) -> Areas {
    let first = x.yzx * y.zxy;
    let second = y.yzx * x.zxy;
    let areas = first - second;
    // Each product is off by at most two units of roundoff, however it is rounded or fused. Their difference is off by
    // two more units of its own size.
    return Areas(areas, abs(areas) > 4.0 * UNIT_ROUNDOFF * (abs(first) + abs(second)));
}

// Whether the signs that are certain show that the ray misses a triangle with these sheared corners.
fn misses(x: vec3<f32>, y: vec3<f32>) -> bool {
    let found = areas_of(x, y);
    let is_positive = found.certain & (found.areas > vec3<f32>(0.0));
    let is_negative = found.certain & (found.areas < vec3<f32>(0.0));
    return any(is_positive) && any(is_negative);
}

fn triangle_hit(shear: Shear, a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> TriangleHit {
    let seen = see_corners(shear, a, b, c, c);
    if misses(seen.x.xyz, seen.y.xyz) {
        return TriangleHit(NO_HIT, false, vec3<f32>(0.0));
    }
    return seen_hit(shear.slope.z, seen.x.xyz, seen.y.xyz, seen.z.xyz);
}

// Where a ray hits a triangle with these sheared corners. `over_z` is 1 over the z of the ray's direction.
fn seen_hit(over_z: f32, x: vec3<f32>, y: vec3<f32>, z: vec3<f32>) -> TriangleHit {
    let miss = TriangleHit(NO_HIT, false, vec3<f32>(0.0));
    let found = areas_of(x, y);
    let areas = found.areas;
    var signs = sign(areas);
    if !all(found.certain) {
        signs = with_close_signs(signs, found.certain, x, y);
    }
    if !(all(signs > vec3<f32>(0.0)) || all(signs < vec3<f32>(0.0))) {
        return miss;
    }
    // The weights. The first is that of the vertex opposite to the shortest edge, a quotient of two areas. Both areas are
    // computed as products with that edge, so they keep their precision in needles. The other two weights share the rest. Their
    // vertices are close together, so the point depends little on how they share it.
    let edge_x = x.zxy - x.yzx;
    let edge_y = y.zxy - y.yzx;
    let edge_z = z.zxy - z.yzx;
    let shift = index_of_least(edge_x * edge_x + edge_y * edge_y + edge_z * edge_z);
    let px = cyclic(x, shift);
    let py = cyclic(y, shift);
    let pz = cyclic(z, shift);
    let ends = cyclic(max(areas * signs, vec3<f32>(0.0)), shift);
    let edge = vec2<f32>(px.z - px.y, py.z - py.y);
    let total = edge.x * (py.x - py.y) - edge.y * (px.x - px.y);
    let part = px.y * edge.y - py.y * edge.x;
    // In a needle, or seen along an edge, areas can be 0 as floats. Then they do not show where in the triangle the hit lies.
    let tip = select(clamp(part / total, 0.0, 1.0), 1.0 / 3.0, total == 0.0);
    let rest = ends.y + ends.z;
    let share = select(clamp(ends.z / rest, 0.0, 1.0), 0.5, rest == 0.0);
    let weights = vec3<f32>(tip, (1.0 - tip) * (1.0 - share), (1.0 - tip) * share);
    let t = dot(weights, pz) * over_z;
    if !(t > 0.0) {
        return miss;
    }
    let front = (signs.x > 0.0) != (over_z > 0.0);
    return TriangleHit(t, front, cyclic(weights, (3u - shift) % 3u));
}

// Bound of the error of a point that is computed from the weights of a hit. It is large enough that a ray which leaves from
// there (leave_surface) does not hit the triangle again. Own derivation, in units of roundoff u. Let m be the sum over x, y, z
// of the vertices' largest coordinate, l and s the longest and the shortest edge, and n twice the area:
// - The point: sums of products with weights that add up to 1 within a few u are off by 7 u m (PBR 4th ed., section 6.8.5).
//   With the rounding of the offset point it is 8 u m.
// - The next test, from a point within l of the vertices: differences, slopes and shear move each sheared vertex by 9 u l, and
//   the direction's slopes are off by 6 u. `part` and `total` are off by 6 u l s each, and their quotient by 5 u. So the point
//   along the needle is off by up to 17 u l (l s / n), and the last difference by 3 u l: together below 32 u l (l s / n). If
//   the point is off within the triangle's plane, the origin's height over that plane is off only by the component along the
//   ray, times the cosine. So grazing rays need no larger bound.
// l s / n is near 1 for all shapes, including needles, except for triangles whose vertices lie nearly on a line with no two of
// them close together. The bound follows l s / n up to 64.
fn triangle_error(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> f32 {
    let largest = max(max(abs(a), abs(b)), abs(c));
    let edges = vec3<f32>(length(b - a), length(c - b), length(a - c));
    let longest = max(max(edges.x, edges.y), edges.z);
    let rectangle = longest * min(min(edges.x, edges.y), edges.z);
    let doubled_area = length(triangle_cross(a, b, c));
    let factor = select(64.0, max(rectangle / doubled_area, 1.0), rectangle < 64.0 * doubled_area);
    return UNIT_ROUNDOFF * (8.0 * (largest.x + largest.y + largest.z) + 32.0 * longest * factor);
}

// The normal times twice the area, on the side from which a, b, c run counter-clockwise. It is computed from the two shortest
// edges. With other edges, a needle's normal loses precision, and grazing rays would get the wrong side.
fn triangle_cross(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> vec3<f32> {
    let ab = b - a;
    let bc = c - b;
    let ca = a - c;
    let squares = vec3<f32>(dot(ab, ab), dot(bc, bc), dot(ca, ca));
    // The longest edge is left out.
    let longest = index_of_least(-squares);
    return select(select(cross(ab, bc), cross(ca, ab), longest == 1u), cross(bc, ca), longest == 0u);
}

//@ use data/ray
//@ use data/surface
//@ use lib/float
//@ relies on signs
// Rays against triangles: no ray passes between triangles that share an edge or a vertex, and none meets two of them there.
// The vertices are sheared so that the ray runs along z, and three edge functions tell on which sides of the edges the
// origin of the x, y plane lies (Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013). Here
// their signs are exact for the sheared vertices, whatever a driver rounds or fuses, and never 0: the origin counts as
// moved by an infinitesimal (Edelsbrunner and Mücke, "Simulation of Simplicity", ACM TOG 9(1), 1990). A sheared vertex
// depends on the ray and the vertex only, so that what is told of one triangle agrees with what is told of its neighbours.
// Holds for coordinates below 2^62 relative to the ray's origin.

struct TriangleHit {
    // NO_HIT, or the distance in lengths of the direction, above 0.
    t: f32,
    // The ray comes from the side on which a, b, c run counter-clockwise.
    front: bool,
    // Weights of a, b and c, none negative; their sum is 1.
    barycentric: vec3<f32>,
}

// What a ray's triangle tests share.
struct Shear {
    // The largest component of the direction: 0, 1 or 2 for x, y or z; it becomes z.
    axis: u32,
    // The origin with its components in the new order.
    origin: vec3<f32>,
    // d.x / d.z and d.y / d.z in the new order, and 1 / d.z.
    slope: vec3<f32>,
}

// The components in cyclic order, ending with the axis: handedness stays.
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

// Below 2^-60 to 0, so that no product of two can be subnormal and flushed.
fn flush_small(v: vec3<f32>) -> vec3<f32> {
    return select(v, vec3<f32>(0.0), abs(v) < vec3<f32>(0x1p-60f));
}

// |x y| exactly, for normal floats: an integer of two digits to the base 2^24, times 2 to the sum of their exponents.
struct ExactProduct {
    high: vec3<u32>,
    low: vec3<u32>,
    exponent: vec3<u32>,
}

fn exact_product(x: vec3<f32>, y: vec3<f32>) -> ExactProduct {
    let x_bits = bitcast<vec3<u32>>(x);
    let y_bits = bitcast<vec3<u32>>(y);
    let m = (x_bits & vec3<u32>(0x7fffffu)) | vec3<u32>(0x800000u);
    let n = (y_bits & vec3<u32>(0x7fffffu)) | vec3<u32>(0x800000u);
    let twelve = vec3<u32>(12u);
    let middle = (m >> twelve) * (n & vec3<u32>(0xfffu)) + (m & vec3<u32>(0xfffu)) * (n >> twelve);
    let low = (m & vec3<u32>(0xfffu)) * (n & vec3<u32>(0xfffu)) + ((middle & vec3<u32>(0xfffu)) << twelve);
    return ExactProduct(
        (m >> twelve) * (n >> twelve) + (middle >> twelve) + (low >> vec3<u32>(24u)),
        low & vec3<u32>(0xffffffu),
        ((x_bits >> vec3<u32>(23u)) & vec3<u32>(255u)) + ((y_bits >> vec3<u32>(23u)) & vec3<u32>(255u)),
    );
}

// The sign of p.x q.y - p.y q.x, for each of three pairs of points, where the two products as floats are both 0 or differ
// by a few roundings: then their exponents differ by one at most. Where the exact difference is 0, the sign is that of
// the same with (e, e^2), e > 0 infinitesimal, subtracted from both points: of e (p.y - q.y) + e^2 (q.x - p.x) + 0 e^3.
// 0 is left for p = q only.
fn close_signs(px: vec3<f32>, py: vec3<f32>, qx: vec3<f32>, qy: vec3<f32>) -> vec3<f32> {
    let one = exact_product(px, qy);
    let other = exact_product(py, qx);
    let most = max(one.exponent, other.exponent);
    // The digits of the product with the larger exponent count twice.
    let one_doubled = select(vec3<u32>(0u), vec3<u32>(1u), one.exponent > other.exponent);
    let other_doubled = select(vec3<u32>(0u), vec3<u32>(1u), other.exponent > one.exponent);
    let high = vec3<i32>(one.high << one_doubled) - vec3<i32>(other.high << other_doubled);
    let low = vec3<i32>(one.low << one_doubled) - vec3<i32>(other.low << other_doubled);
    // |low| is below 2 x 2^24, so that beyond a difference of 4 the high digits decide alone.
    let larger = sign(clamp(high, vec3<i32>(-4), vec3<i32>(4)) * 0x1000000 + low);
    let first = px * qy;
    let difference = sign(first) * vec3<f32>(larger);
    let moved_x = select(select(vec3<f32>(0.0), vec3<f32>(-1.0), qx < px), vec3<f32>(1.0), qx > px);
    let moved_y = select(select(moved_x, vec3<f32>(-1.0), py < qy), vec3<f32>(1.0), py > qy);
    return select(moved_y, difference, difference != vec3<f32>(0.0));
}

// The components in cyclic order, starting with x, y or z as turn is 0, 1 or 2.
fn turned(v: vec3<f32>, turn: u32) -> vec3<f32> {
    return select(select(v, v.yzx, turn == 1u), v.zxy, turn == 2u);
}

fn place_of_least(v: vec3<f32>) -> u32 {
    return select(select(2u, 1u, v.y <= v.z), 0u, v.x <= v.y && v.x <= v.z);
}

fn triangle_hit(shear: Shear, a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> TriangleHit {
    let miss = TriangleHit(NO_HIT, false, vec3<f32>(0.0));
    let from_a = end_with_axis(a, shear.axis) - shear.origin;
    let from_b = end_with_axis(b, shear.axis) - shear.origin;
    let from_c = end_with_axis(c, shear.axis) - shear.origin;
    // One expression for the three vertices, so that each goes through the same operations in every triangle.
    let z = vec3<f32>(from_a.z, from_b.z, from_c.z);
    let x = flush_small(vec3<f32>(from_a.x, from_b.x, from_c.x) - shear.slope.x * z);
    let y = flush_small(vec3<f32>(from_a.y, from_b.y, from_c.y) - shear.slope.y * z);
    // Twice the signed areas between the origin and the edges opposite to a, b, c.
    let first = x.yzx * y.zxy;
    let second = y.yzx * x.zxy;
    let areas = first - second;
    // The products are off by two units of roundoff at most, whichever way they are rounded or fused; the sum adds two of
    // itself.
    let certain = abs(areas) > 4.0 * UNIT_ROUNDOFF * (abs(first) + abs(second));
    if any(certain & areas > vec3<f32>(0.0)) && any(certain & areas < vec3<f32>(0.0)) {
        return miss;
    }
    var signs = sign(areas);
    if !all(certain) {
        signs = select(close_signs(x.yzx, y.yzx, x.zxy, y.zxy), signs, certain);
    }
    if !(all(signs > vec3<f32>(0.0)) || all(signs < vec3<f32>(0.0))) {
        return miss;
    }
    // The weights, from the vertex opposite to the shortest edge: its area and the whole one as products with that edge
    // keep their digits in needles, and between the near ends of the edge little depends on the weights.
    let edge_x = x.zxy - x.yzx;
    let edge_y = y.zxy - y.yzx;
    let edge_z = z.zxy - z.yzx;
    let turn = place_of_least(edge_x * edge_x + edge_y * edge_y + edge_z * edge_z);
    let px = turned(x, turn);
    let py = turned(y, turn);
    let pz = turned(z, turn);
    let ends = turned(max(areas * signs, vec3<f32>(0.0)), turn);
    let edge = vec2<f32>(px.z - px.y, py.z - py.y);
    let whole = edge.x * (py.x - py.y) - edge.y * (px.x - px.y);
    let part = px.y * edge.y - py.y * edge.x;
    // Areas that are 0 as floats, seen along an edge or a needle, say nothing of the place within.
    let tip = select(clamp(part / whole, 0.0, 1.0), 1.0 / 3.0, whole == 0.0);
    let rest = ends.y + ends.z;
    let share = select(clamp(ends.z / rest, 0.0, 1.0), 0.5, rest == 0.0);
    let weights = vec3<f32>(tip, (1.0 - tip) * (1.0 - share), (1.0 - tip) * share);
    let t = dot(weights, pz) * shear.slope.z;
    if !(t > 0.0) {
        return miss;
    }
    let front = (signs.x > 0.0) != (shear.slope.z > 0.0);
    return TriangleHit(t, front, turned(weights, (3u - turn) % 3u));
}

// Bound of the error of a point made of the weights of a hit, with what it takes that a ray which leaves from there by
// leave_surface does not meet the triangle again. Own derivation, in units of roundoff u, with m the sum over x, y, z of the
// largest coordinate, l and s the longest and the shortest edge, n twice the area:
// - the point: sums of products by weights that add up to 1 within a few u are off by 7 u m (PBR 4th ed., section 6.8.5);
//   8 u m with the rounding of the offset point itself;
// - the next test, from a point within l of the vertices: differences, slopes and shear move each sheared vertex by 9 u l,
//   and the direction's slopes are off by 6 u; part and whole are off by 6 u l s each, the quotient by 5 u, and with them
//   the place along the needle by up to 17 u l (l s / n), the last difference by 3 u l: together below 32 u l (l s / n).
//   A place that is off within the triangle's plane changes the height of the origin over that plane by its
//   component along the ray, times the cosine: grazing rays need no more.
// l s / n is near 1 for all shapes, needles too, but for triangles whose vertices lie nearly on a line with none close to
// another; beyond 64 the bound does not follow it.
fn triangle_error(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> f32 {
    let largest = max(max(abs(a), abs(b)), abs(c));
    let edges = vec3<f32>(length(b - a), length(c - b), length(a - c));
    let longest = max(max(edges.x, edges.y), edges.z);
    let rectangle = longest * min(min(edges.x, edges.y), edges.z);
    let doubled_area = length(triangle_cross(a, b, c));
    let factor = select(64.0, max(rectangle / doubled_area, 1.0), rectangle < 64.0 * doubled_area);
    return UNIT_ROUNDOFF * (8.0 * (largest.x + largest.y + largest.z) + 32.0 * longest * factor);
}

// Twice the area along the normal on the side from which a, b, c run counter-clockwise. From the two shortest edges: with
// others a needle's normal loses digits, and grazing rays would be told the wrong side.
fn triangle_cross(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> vec3<f32> {
    let ab = b - a;
    let bc = c - b;
    let ca = a - c;
    let squares = vec3<f32>(dot(ab, ab), dot(bc, bc), dot(ca, ca));
    // The longest edge is left out.
    let longest = place_of_least(-squares);
    return select(select(cross(ab, bc), cross(ca, ab), longest == 1u), cross(bc, ca), longest == 0u);
}

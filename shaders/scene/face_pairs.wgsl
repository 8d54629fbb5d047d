//@ use geometry/slab
//@ use geometry/sheared_triangle
// The leaves of a mesh's hierarchy: pairs of faces that share two corners. So a walk reads only four corners for two faces.

// A pair as a ray sees it.
struct SeenPair {
    corners: SeenCorners,
    // 1 over the z of the ray's direction.
    over_z: f32,
    // The codes of both faces.
    faces: vec2<u32>,
    // The corners of the second face: two bits each.
    corners_of_second: u32,
    // The faces that the ray may hit: a bit for each.
    left: u32,
}

const FIRST_OF_PAIR: u32 = 1u;
const SECOND_OF_PAIR: u32 = 2u;
const BOTH_FACES: u32 = 3u;

// The corners of the first face: 0, 1 and 2.
const CORNERS_OF_FIRST: u32 = 0x24u;

// Returns three of four numbers. Two bits of `corners` select each.
fn three_of(numbers: vec4<f32>, corners: u32) -> vec3<f32> {
    let corner = vec3<u32>(corners) >> vec3<u32>(0u, 2u, 4u);
    let odd = (corner & vec3<u32>(1u)) != vec3<u32>(0u);
    let low = select(vec3<f32>(numbers.x), vec3<f32>(numbers.y), odd);
    let high = select(vec3<f32>(numbers.z), vec3<f32>(numbers.w), odd);
    return select(low, high, (corner & vec3<u32>(2u)) != vec3<u32>(0u));
}

// Returns a pair as a ray in the mesh's space sees it, without the faces whose bits are in `tested`. `inverse` is
// slab_inverse(ray.direction).
fn see_pair(pair: FacePair, ray: Ray, inverse: vec3<f32>, tested: u32) -> SeenPair {
    let shear = shear_along(ray, inverse);
    let a = bitcast<vec3<f32>>(pair.a.xyz);
    let b = bitcast<vec3<f32>>(pair.b.xyz);
    let c = bitcast<vec3<f32>>(pair.c.xyz);
    let d = bitcast<vec3<f32>>(pair.d.xyz);
    let seen = see_corners(shear, a, b, c, d);
    let faces = vec2<u32>(pair.a.w, pair.b.w);
    let second = pair.c.w;
    let may_hit_first = !misses(seen.x.xyz, seen.y.xyz);
    let may_hit_second = faces.y != NO_FACE && !misses(three_of(seen.x, second), three_of(seen.y, second));
    let left = select(0u, FIRST_OF_PAIR, may_hit_first) | select(0u, SECOND_OF_PAIR, may_hit_second);
    return SeenPair(seen, shear.slope.z, faces, second, left & ~tested);
}

// Whether the first of the faces that are left is the pair's second.
fn is_second(pair: SeenPair) -> bool {
    return (pair.left & FIRST_OF_PAIR) == 0u;
}

// Where the ray hits the first of the faces that are left.
fn hit_of_pair(pair: SeenPair) -> TriangleHit {
    let corners = select(CORNERS_OF_FIRST, pair.corners_of_second, is_second(pair));
    let seen = pair.corners;
    return seen_hit(pair.over_z, three_of(seen.x, corners), three_of(seen.y, corners), three_of(seen.z, corners));
}

// An iteration of a walk tests one face: the first of those that are left. The ray can rarely hit the other one too, which is then
// tested by the next iteration. Returns the bit of the face that this iteration tests if the other one is left too, or 0.
fn tested_before_other(pair: SeenPair) -> u32 {
    return select(0u, FIRST_OF_PAIR, pair.left == BOTH_FACES);
}

// The code of the first of the faces that are left.
fn code_of_face(pair: SeenPair) -> u32 {
    return select(pair.faces.x, pair.faces.y, is_second(pair));
}

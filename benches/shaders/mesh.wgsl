//@ use data/ray
//@ use lib/float
// Triangles for the walks to compare: one plain test for all alike.
@group(0) @binding(1) var<storage, read> vertices: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> triangles: array<vec4<u32>>;

// A leaf's code: the highest bit, the number of its triangles less one in the next three, the first of them in the rest.
const LEAF_BIT: u32 = 0x80000000u;
const NO_TRIANGLE: u32 = 0xffffffffu;

struct Found {
    t: f32,
    triangle: u32,
    steps: u32,
}

// Moeller and Trumbore 1997.
fn triangle_distance(corners: vec4<u32>, ray: Ray) -> f32 {
    let a = vertices[corners.x].xyz;
    let ab = vertices[corners.y].xyz - a;
    let ac = vertices[corners.z].xyz - a;
    let p = cross(ray.direction, ac);
    let inverse = 1.0 / dot(ab, p);
    let s = ray.origin - a;
    let u = dot(s, p) * inverse;
    let q = cross(s, ab);
    let v = dot(ray.direction, q) * inverse;
    let t = dot(ac, q) * inverse;
    return select(VERY_FAR, t, u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 1e-5);
}

fn meet_leaf(code: u32, ray: Ray, found: ptr<function, Found>) {
    let first = code & 0x0fffffffu;
    let end = first + ((code >> 28u) & 7u) + 1u;
    for (var i = first; i < end; i++) {
        let t = triangle_distance(triangles[i], ray);
        if t < (*found).t {
            (*found).t = t;
            (*found).triangle = triangles[i].w;
        }
    }
}

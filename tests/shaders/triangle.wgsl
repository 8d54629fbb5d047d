//@ use geometry/sheared_triangle
//@ use geometry/offset
//@ use geometry/slab
// A ray against all triangles of a range: how often it leaves and enters through them, and where it meets the nearest;
// then a second ray from there against that triangle alone.
struct In {
    origin: vec3<f32>,
    first: u32,
    direction: vec3<f32>,
    count: u32,
    // The second ray's direction; it is not traced where this is zero.
    leaving: vec3<f32>,
    padding: u32,
}

struct Out {
    // Triangles met from their clockwise side and from their counter-clockwise side.
    back: u32,
    front: u32,
    nearest: u32,
    t: f32,
    barycentric: vec3<f32>,
    // Distance of the second ray's hit.
    again: f32,
    error: f32,
    padding0: f32,
    padding1: f32,
    padding2: f32,
}

struct Corners {
    a: vec3<f32>,
    b: vec3<f32>,
    c: vec3<f32>,
}

@group(0) @binding(23) var<storage, read> triangles: array<Corners>;

fn run(row: u32) {
    let given = input[row];
    let ray = Ray(given.origin, given.direction);
    let shear = shear_along(ray, slab_inverse(ray.direction));
    var out: Out;
    out.t = NO_HIT;
    out.again = NO_HIT;
    for (var i = given.first; i < given.first + given.count; i++) {
        let corners = triangles[i];
        let hit = triangle_hit(shear, corners.a, corners.b, corners.c);
        if hit.t != NO_HIT {
            if hit.front {
                out.front++;
            } else {
                out.back++;
            }
            if out.t == NO_HIT || hit.t < out.t {
                out.t = hit.t;
                out.nearest = i;
                out.barycentric = hit.barycentric;
            }
        }
    }
    if out.t != NO_HIT {
        let at = triangles[out.nearest];
        out.error = triangle_error(at.a, at.b, at.c);
        if any(given.leaving != vec3<f32>(0.0)) {
            let point = out.barycentric.x * at.a + out.barycentric.y * at.b + out.barycentric.z * at.c;
            let normal = normalize(triangle_cross(at.a, at.b, at.c));
            let start = leave_surface(point, out.error, normal, given.leaving);
            let second = Ray(start, given.leaving);
            out.again = triangle_hit(shear_along(second, slab_inverse(second.direction)), at.a, at.b, at.c).t;
        }
    }
    output[row] = out;
}

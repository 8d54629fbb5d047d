//@ use geometry/${primitive}
//@ use geometry/offset
// A ray against one primitive, the hit record where it meets it, and a second ray that leaves from there.
struct In {
    origin: vec3<f32>,
    primitive: u32,
    direction: vec3<f32>,
    padding0: u32,
    // The second ray's direction, in a basis around the normal; zero to go on as the first ray does.
    leaving: vec3<f32>,
    padding1: u32,
}

struct Out {
    point: vec3<f32>,
    t: f32,
    normal: vec3<f32>,
    error: f32,
    local: vec3<f32>,
    // Distance of the second ray's hit.
    again: f32,
    start: vec3<f32>,
    u: f32,
    leaving: vec3<f32>,
    v: f32,
}

@group(0) @binding(23) var<storage, read> primitives: array<${type}>;

fn run(row: u32) {
    let given = input[row];
    let primitive = primitives[given.primitive];
    let ray = Ray(given.origin, given.direction);
    var out: Out;
    out.t = ${primitive}_distance(ray, primitive);
    out.again = NO_HIT;
    if out.t != NO_HIT {
        let surface = ${primitive}_surface(ray, out.t, primitive);
        var leaving = ray.direction;
        if any(given.leaving != vec3<f32>(0.0)) {
            leaving = normalize(from_basis(basis_around(surface.normal), given.leaving));
        }
        let start = leave_surface(surface.point, surface.error, surface.normal, leaving);
        let place = ${primitive}_uv(primitive, surface.local, surface.local);
        out.point = surface.point;
        out.normal = surface.normal;
        out.error = surface.error;
        out.local = surface.local;
        out.start = start;
        out.leaving = leaving;
        out.u = place.uv.x;
        out.v = place.uv.y;
        out.again = ${primitive}_distance(Ray(start, leaving), primitive);
    }
    output[row] = out;
}

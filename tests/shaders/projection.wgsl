//@ use choice/camera
//@ use choice/camera_view
struct In {
    column: u32,
    row: u32,
    padding0: u32,
    padding1: u32,
    u: vec4<f32>,
}

struct Out {
    origin: vec3<f32>,
    density: f32,
    direction: vec3<f32>,
    padding0: u32,
    point: vec2<f32>,
    padding1: vec2<u32>,
}

// A ray, and how the camera sees the point at distance 1 on it, from the same point of the lens.
fn run(row: u32) {
    let given = input[row];
    let ray = camera_ray(given.column, given.row, given.u);
    let view = view_from_camera(ray.origin + ray.direction, given.u.zwxy);
    output[row] = Out(ray.origin, view.density, ray.direction, 0u, view.film_point, vec2<u32>(0u));
}

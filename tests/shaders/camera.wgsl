//@ use camera/${camera}
struct In {
    column: u32,
    row: u32,
    padding0: u32,
    padding1: u32,
    u: vec4<f32>,
}

struct Out {
    origin: vec3<f32>,
    padding0: u32,
    direction: vec3<f32>,
    padding1: u32,
}

fn run(row: u32) {
    let given = input[row];
    let ray = camera_ray(given.column, given.row, given.u);
    output[row] = Out(ray.origin, 0u, ray.direction, 0u);
}

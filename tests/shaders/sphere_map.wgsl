struct In {
    direction: vec3<f32>,
    padding: u32,
}

struct Out {
    uv: vec2<f32>,
    sky: vec2<f32>,
}

fn run(row: u32) {
    output[row] = Out(sphere_uv_at(input[row].direction), sky_uv(input[row].direction));
}

//@ use texture/${texture}
struct In {
    texture: Texture,
    point: vec3<f32>,
    along_z: f32,
    uv: vec2<f32>,
    phase: f32,
    // 1 for left and right, 2 for top and bottom.
    wraps: u32,
}

struct Out {
    colour: vec3<f32>,
    padding: u32,
}

fn run(row: u32) {
    let given = input[row];
    let at = TexturePoint(given.point, given.along_z, given.phase, given.uv, (vec2<u32>(given.wraps) & vec2<u32>(1u, 2u)) != vec2<u32>(0u));
    output[row] = Out(${texture}_colour(given.texture, at), 0u);
}

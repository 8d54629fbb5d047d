// The reflectance of a thin film.
struct In {
    f0: vec3<f32>,
    cosine: f32,
    ior: f32,
    thickness: f32,
    padding: vec2<f32>,
}

alias Out = vec4<f32>;

fn run(row: u32) {
    let given = input[row];
    output[row] = vec4<f32>(thin_film(given.cosine, given.ior, given.thickness, given.f0), 0.0);
}

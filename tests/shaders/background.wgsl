//@ use background/${kind}
struct In {
    direction: vec3<f32>,
    padding: u32,
}

struct Out {
    radiance: vec3<f32>,
    padding: u32,
}

fn run(row: u32) {
    output[row] = Out(${kind}_background(input[row].direction), 0u);
}

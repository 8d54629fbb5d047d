//@ use medium/${primitive}
// The part of a ray within a shape, and where the ray meets it first as a surface.
struct In {
    origin: vec3<f32>,
    primitive: u32,
    direction: vec3<f32>,
    padding: u32,
}

struct Out {
    interval: vec2<f32>,
    distance: f32,
    padding: f32,
}

@group(0) @binding(23) var<storage, read> primitives: array<${type}>;

fn run(row: u32) {
    let given = input[row];
    let ray = Ray(given.origin, given.direction);
    let primitive = primitives[given.primitive];
    output[row] = Out(${primitive}_interval(ray, primitive), ${primitive}_distance(ray, primitive), 0.0);
}

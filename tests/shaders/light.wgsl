//@ use test/light_${shape}
//@ use sampler/independent
// Directions towards a light and their densities; for the uniforms given, or for many of the row's own.
struct In {
    from_point: vec3<f32>,
    shape: u32,
    u: vec2<f32>,
    padding: vec2<f32>,
}

struct Out {
    direction: vec3<f32>,
    pdf: f32,
    // The density of the direction computed without having sampled it.
    again: f32,
    // Where a ray in the direction meets the light.
    distance: f32,
    padding: vec2<f32>,
}

@group(0) @binding(21) var<storage, read> input: array<In>;
@group(0) @binding(22) var<storage, read_write> output: array<Out>;
@group(0) @binding(23) var<storage, read> shapes: array<${type}>;

fn run(row: u32) {
    let given = input[row / ${draws}u];
    var u = given.u;
    if ${draws}u > 1u {
        u = random4(row, 0u, 0u, 1u).xy;
    }
    let shape = shapes[given.shape];
    let sampled = shape_sample(given.from_point, shape, u);
    let again = shape_pdf(given.from_point, sampled.direction, shape);
    let distance = shape_distance(Ray(given.from_point, sampled.direction), shape);
    output[row] = Out(sampled.direction, sampled.pdf, again, distance, vec2<f32>(0.0));
}

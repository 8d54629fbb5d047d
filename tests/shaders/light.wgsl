//@ use light/${light}
//@ use geometry/${shape}
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

@group(0) @binding(23) var<storage, read> shapes: array<${type}>;

fn run(row: u32) {
    let given = input[row / job.times];
    let u = select(given.u, random4(row, 0u, 0u, 1u).xy, job.times > 1u);
    let shape = shapes[given.shape];
    let from_point = given.from_point;
    let sampled = ${sample};
    let ray = Ray(from_point, sampled.direction);
    let again = ${pdf};
    let distance = ${distance};
    output[row] = Out(sampled.direction, sampled.pdf, again, distance, vec2<f32>(0.0));
}

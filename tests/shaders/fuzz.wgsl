//@ use sampler/independent
//@ use material/metal
//@ use material/metal_eval
// A metal's answer to a ray, with the density of the direction that it drew; for the uniforms given, or many times for the
// rows' own.
struct In {
    incoming: vec3<f32>,
    fuzz: f32,
    normal: vec3<f32>,
    padding: u32,
    u: vec4<f32>,
}

struct Out {
    direction: vec3<f32>,
    event: u32,
    pdf: f32,
    // Of the albedo 1: the density once more.
    value: f32,
    padding0: u32,
    padding1: u32,
}

fn run(row: u32) {
    let given = input[row / job.times];
    let u = select(given.u, random4(row, 0u, 0u, 2u), job.times > 1u);
    var hit: Interaction;
    hit.incoming = given.incoming;
    hit.normal = given.normal;
    hit.front = true;
    hit.colour = vec3<f32>(1.0);
    var material: Material;
    material.${metal.fuzz} = given.fuzz;
    let scattered = metal_scatter(material, hit, u);
    let response = metal_eval(material, hit, scattered.direction);
    output[row] = Out(scattered.direction, scattered.event, response.pdf, response.value.x, 0u, 0u);
}

//@ use sampler/independent
//@ use material/${material}
// A material's answer to a ray: for the uniforms given, or many times for the rows' own.
struct In {
    incoming: vec3<f32>,
    front: u32,
    normal: vec3<f32>,
    padding0: u32,
    colour: vec3<f32>,
    padding1: u32,
    u: vec4<f32>,
    material: Material,
}

struct Out {
    direction: vec3<f32>,
    event: u32,
    weight: vec3<f32>,
    padding: u32,
}

fn run(row: u32) {
    let given = input[row / job.times];
    let u = select(given.u, random4(row, 0u, 0u, 2u), job.times > 1u);
    var hit: Interaction;
    hit.incoming = given.incoming;
    hit.normal = given.normal;
    hit.front = given.front != 0u;
    hit.colour = given.colour;
    let scattered = ${material}_scatter(given.material, hit, u);
    output[row] = Out(scattered.direction, scattered.event, scattered.weight, 0u);
}

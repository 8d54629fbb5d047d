//@ use sampler/independent
//@ use material/${material}
//@ use material/${material}_eval
//@ use lobe/layers
// The answer to a ray of a material with two parts, and its response to a direction: the one given, or its own answer. For the
// uniforms given, or many times for the rows' own.
struct In {
    incoming: vec3<f32>,
    front: u32,
    normal: vec3<f32>,
    followed: f32,
    colour: vec3<f32>,
    padding1: u32,
    // Zero to get the response to the answer.
    light: vec3<f32>,
    compensation: f32,
    u: vec4<f32>,
    material: Material,
    second: Material,
    f0: vec3<f32>,
    f90: f32,
    lobes: Lobes,
    coat_normal: vec3<f32>,
    padding2: u32,
    tangent: vec3<f32>,
    beckmann: f32,
}

struct Out {
    direction: vec3<f32>,
    event: u32,
    weight: vec3<f32>,
    pdf: f32,
    value: vec3<f32>,
    non_specular: u32,
    lobe: u32,
    narrow: f32,
    padding: vec2<u32>,
}

fn run(row: u32) {
    let given = input[row / job.times];
    let u = select(given.u, random4(row, 0u, 0u, 2u), job.times > 1u);
    var hit: Interaction;
    hit.incoming = given.incoming;
    hit.normal = given.normal;
    hit.front = given.front != 0u;
    hit.colour = given.colour;
    hit.second = given.second;
    hit.compensation = given.compensation;
    hit.f0 = given.f0;
    hit.f90 = given.f90;
    hit.lobes = given.lobes;
    hit.coat_normal = given.coat_normal;
    hit.tangent = given.tangent;
    hit.beckmann = given.beckmann;
    hit.followed = given.followed;
    let scattered = ${material}_scatter(given.material, hit, u);
    let light = select(given.light, scattered.direction, all(given.light == vec3<f32>(0.0)));
    let response = ${material}_eval(given.material, hit, light);
    let spreads = layers_spread(given.material, given.lobes, ${material}_is_non_specular(given.material));
    output[row] = Out(
        scattered.direction, scattered.event, scattered.weight, response.pdf, response.value, select(0u, 1u, spreads),
        scattered.lobe, response.narrow, vec2<u32>());
}

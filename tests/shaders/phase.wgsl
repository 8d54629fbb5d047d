//@ use medium/phase
//@ use sampler/independent
// The cosine and the direction after scattering; of the numbers given, or of the row's own.
struct In {
    incoming: vec3<f32>,
    g: f32,
    u: vec2<f32>,
    one_minus_g: f32,
    padding: f32,
}

struct Out {
    direction: vec3<f32>,
    padding: f32,
    from_one: vec2<f32>,
    padding2: vec2<f32>,
}

fn run(row: u32) {
    var given = input[row / job.times];
    given.u = select(given.u, random4(row, 0u, 0u, 1u).xy, job.times > 1u);
    let direction = sample_phase(given.incoming, given.g, given.one_minus_g, given.u);
    let from_one = henyey_greenstein(given.g, given.one_minus_g, given.u.x);
    output[row] = Out(direction, 0.0, from_one, vec2<f32>(0.0));
}

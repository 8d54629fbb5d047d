//@ use choice/light_choice
//@ use sampler/independent
// Lights chosen for a point, many times, and the probability of each.
struct In {
    from_point: vec3<f32>,
    padding: u32,
}

struct Out {
    index: u32,
    probability: f32,
    // The probability of the same light computed without having chosen it.
    again: f32,
    // That of another light: each row has one light's.
    of_row: f32,
}

fn run(row: u32) {
    let from_point = input[row / job.times].from_point;
    let choice = choose_light(from_point, random4(row, 0u, 0u, 1u).xw);
    let of_row = light_probability((row % job.times) % ${lights}u, from_point);
    output[row] = Out(choice.index, choice.probability, light_probability(choice.index, from_point), of_row);
}

//@ use choice/falloff
//@ use light/delta_distance
// What a light without size sends to a point, and where a shadow ray to it ends.
struct In {
    from_point: vec3<f32>,
    light: u32,
}

struct Out {
    direction: vec3<f32>,
    distance2: f32,
    intensity: vec3<f32>,
    end: f32,
}

@group(0) @binding(23) var<storage, read> shapes: array<DeltaLight>;

fn run(row: u32) {
    let given = input[row];
    let light = shapes[given.light];
    let sample = delta_light_sample(given.from_point, light);
    let end = delta_light_distance(given.from_point, sample.direction, light);
    output[row] = Out(sample.direction, sample.pdf, delta_light_intensity(sample.direction, light), end);
}

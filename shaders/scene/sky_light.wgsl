//@ implements sky_light when sky_light
//@ use choice/axes
//@ use choice/light_choice
//@ use light/sample
//@ use scene/sky
//@ use scene/background
//@ use scene/at_run_time
// The background's image as a light.

const SKY_COLUMNS: u32 = ${sky_columns}u;
const SKY_ROWS: u32 = ${sky_rows}u;

// The last two uniform numbers are stratified together.
fn sky_light_sample(u: vec3<f32>) -> DirectionSample {
    let point = sky_point(u.yz, SKY_COLUMNS, SKY_ROWS);
    let direction = sky_direction(point);
    return DirectionSample(from_world(direction), sky_pdf(direction, point, SKY_COLUMNS, SKY_ROWS));
}

// The pdf of light sampling for a direction to the sky: the probability of choosing the sky, which is the last of all lights,
// times the pdf of the direction.
fn sky_density(from_point: vec3<f32>, direction: vec3<f32>) -> f32 {
    let of_world = to_world(direction);
    let pdf = sky_pdf(of_world, sky_uv(of_world), SKY_COLUMNS, SKY_ROWS);
    return light_probability(at_run_time(${sky_light}u), from_point) * pdf;
}

fn emitted_by_sky(direction: vec3<f32>) -> vec3<f32> {
    return background_radiance(direction);
}

//@ without
//@ use light/sample
// The sky is not sampled as a light.
fn sky_light_sample(u: vec3<f32>) -> DirectionSample {
    return NO_DIRECTION_SAMPLE;
}

fn emitted_by_sky(direction: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(0.0);
}

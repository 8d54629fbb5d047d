//@ use bind/sky
//@ use choice/axes
//@ use choice/light_choice
//@ use light/alias
//@ use light/sky
//@ use scene/background
//@ use scene/at_run_time
// The background's image as a light.

const SKY_COLUMNS: u32 = ${sky_columns}u;
const SKY_ROWS: u32 = ${sky_rows}u;

fn sky_light_sample(u: vec3<f32>) -> DirectionSample {
    let pick = alias_pick(u.z, SKY_COLUMNS * SKY_ROWS);
    let choice = alias_choice(pick, sky[pick.index]);
    let direction = sky_cell_direction(choice.index, SKY_COLUMNS, SKY_ROWS, u.xy);
    return DirectionSample(from_world(direction), choice.density);
}

// The pdf of light sampling for a direction to the sky: the probability of choosing the sky, which is the last of all lights,
// times the pdf of the direction.
fn sky_density(from_point: vec3<f32>, direction: vec3<f32>) -> f32 {
    let density = sky[sky_cell_at(to_world(direction), SKY_COLUMNS, SKY_ROWS)].density;
    return light_probability(at_run_time(${sky_light}u), from_point) * density;
}

fn emitted_by_sky(direction: vec3<f32>) -> vec3<f32> {
    return background_radiance(direction);
}

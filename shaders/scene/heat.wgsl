//@ implements heat when blackbody
//@ use bind/bricks
//@ use bind/fields
//@ use choice/moved_medium
//@ use medium/grid
//@ use scene/at_run_time
//@ use scene/field
// The radiance of black bodies by a table (src/volume/heat.rs).

// The inverse temperatures of the first row and of the last one, in 1/K, and the intervals between the rows.
const FIRST_INVERSE: f32 = 2.5e-5;
const LAST_INVERSE: f32 = 2e-3;
const INTERVALS_OF_HEAT: f32 = 2048.0;

fn row_of_heat(field: ScalarField, row: u32) -> vec4<f32> {
    let at = field.heat + 4u * row;
    return bitcast<vec4<f32>>(vec4<u32>(bricks[at], bricks[at + 1u], bricks[at + 2u], bricks[at + 3u]));
}

// The radiance of a black body. Below the coldest temperature of the table it is 0; above the hottest one it is that one's.
fn radiance_of_heat(field: ScalarField, kelvins: f32) -> vec3<f32> {
    let place = (1.0 / kelvins - FIRST_INVERSE) * (INTERVALS_OF_HEAT / (LAST_INVERSE - FIRST_INVERSE));
    if !(place <= INTERVALS_OF_HEAT) {
        return vec3<f32>(0.0);
    }
    let within = max(place, 0.0);
    let row = min(floor(within), INTERVALS_OF_HEAT - 1.0);
    let mixed = mix(row_of_heat(field, u32(row)), row_of_heat(field, u32(row) + 1u), within - row);
    return exp(mixed.x) * mixed.yzw;
}

// How bright a medium is at a point, by the temperature there.
fn heat_at(medium: Medium, field: ScalarField, point: vec3<f32>) -> vec3<f32> {
    if field.temperature == NO_FIELD {
        return vec3<f32>(1.0);
    }
    let temperature = fields[at_run_time(field.temperature)];
    let position = position_in_field(temperature, vec4<f32>(offset_at_rest(medium, point), 1.0));
    return radiance_of_heat(field, value_in_grid(temperature, position));
}

//@ without
// No medium has a temperature.
fn heat_at(medium: Medium, field: ScalarField, point: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(1.0);
}

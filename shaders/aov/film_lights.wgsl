//@ implements film_lights when aov.lights
//@ use step/film
// The sums of groups of lights on the film: of each group those of even and of odd runs, and those of their light paths.

fn add_lights_of_run(pixel: u32, run: RunRecord) {
    let half = run.counts >> 31u;
    for (var i = 0u; i < 3u * ${light_groups}u; i++) {
        let sum = FIRST_LIGHT_SUM + ${sums_of_group}u * (i / 3u) + 3u * half + i % 3u;
        add_to_film(pixel, sum, run.aov[${plain_sums}u + i], SUM_FRACTION);
    }
}

//@ without
// The film has no groups of lights.
fn add_lights_of_run(pixel: u32, run: RunRecord) {
}

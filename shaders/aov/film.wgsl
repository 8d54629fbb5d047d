//@ implements aov_film when aov
//@ use step/film
// The sums of `--aov` on the film.

// They follow those of the radiance.
const SUMS_OF_RADIANCE: u32 = 9u;

fn add_aov(pixel: u32, run: RunRecord) {
    for (var i = 0u; i < ${plain_sums}u; i++) {
        add_to_film(pixel, SUMS_OF_RADIANCE + i, run.aov[i], SUM_FRACTION);
    }
}

//@ without
// The film has no channel but radiance.
fn add_aov(pixel: u32, run: RunRecord) {
}

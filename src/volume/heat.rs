//! The colours of black bodies, as kernels read them (shaders/medium/heat).

use std::sync::LazyLock;

use glam::DVec3;

use crate::data::luminance;
use crate::scene::of_black_body;

/// The temperatures of the table, in kelvins. What is colder emits nothing that shows: its luminance is 1e-13 of that at 1500 kelvins.
pub const COLDEST: f64 = 500.0;
pub const HOTTEST: f64 = 40_000.0;

/// The intervals of the table. Its rows are those of inverse temperatures, evenly spaced: by these the logarithm of the luminance is almost a line.
/// Between the rows, the luminance is off by at most 2e-4 of itself (a test measures it).
pub const INTERVALS: u32 = 2048;

/// The inverse temperature of a row, in 1/K.
fn inverse_of(row: u32) -> f64 {
    1.0 / HOTTEST + (1.0 / COLDEST - 1.0 / HOTTEST) * f64::from(row) / f64::from(INTERVALS)
}

/// For each row the logarithm of the luminance, then the colour of luminance 1, without negative channels. Luminance is that of W / (m² sr nm).
pub static TABLE: LazyLock<Vec<[f32; 4]>> = LazyLock::new(|| {
    let row = |number: u32| {
        let colour = of_black_body(1.0 / inverse_of(number));
        let luminance = luminance(colour.to_array());
        let shown = (colour / luminance).max(DVec3::ZERO);
        [luminance.ln(), shown.x, shown.y, shown.z].map(|x| x as f32)
    };
    (0..=INTERVALS).map(row).collect()
});

/// The radiance of a black body; 0 below the coldest temperature.
pub fn radiance(kelvins: f64) -> DVec3 {
    if kelvins < COLDEST { DVec3::ZERO } else { of_black_body(kelvins.min(HOTTEST)).max(DVec3::ZERO) }
}

/// The logarithm of the luminance of a black body.
pub fn log_luminance(kelvins: f64) -> f64 {
    luminance(of_black_body(kelvins).to_array()).ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_the_rows_the_table_is_right() {
        for number in 0..INTERVALS {
            let (before, after) = (TABLE[number as usize], TABLE[number as usize + 1]);
            let middle = 0.5 * (inverse_of(number) + inverse_of(number + 1));
            let exact = of_black_body(1.0 / middle);
            let mean = |i: usize| 0.5 * f64::from(before[i] + after[i]);
            let luminance_there = luminance(exact.to_array());
            let off = (mean(0) - luminance_there.ln()).abs();
            assert!(off < 2e-4, "{} K: {off}", 1.0 / middle);
            let colour = DVec3::new(mean(1), mean(2), mean(3));
            let apart = (colour - (exact / luminance_there).max(DVec3::ZERO)).abs().max_element();
            assert!(apart < 2e-3, "{} K: {apart}", 1.0 / middle);
        }
    }
}

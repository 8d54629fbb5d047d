//! The result of a comparison in one sentence.

use super::difference::{Difference, Local, MeanDifference};
use super::estimate::LEVEL;
use super::images::{QUANTITIES, Quantity};
use super::pixels::{Pixels, Single};

/// Says whether and how A differs from B by more than noise. The sentence contains "noise only", or else says that A is
/// "brighter" or "darker". If noise alone is found, it says which differences of single pixels would not show.
pub fn verdict(difference: &Difference) -> String {
    let (without, [(luminance, p), colours @ ..]) = match &difference.rest {
        None => (String::new(), &difference.means),
        Some((1, means)) => (" without the pixel that holds most of the noise".to_string(), means),
        Some((pixels, means)) => (format!(" without the {pixels} pixels that hold most of the noise"), means),
    };
    let local = difference.local.filter(|local| local.p < LEVEL);
    let around = |local: Local| format!(", most clearly around {}", centre_of(&local));
    if difference.identical {
        return "A differs by noise only, p = 1: the images are identical".to_string();
    }
    if *p < LEVEL {
        return format!("A is {}{without}{}", amount(luminance), local.map(around).unwrap_or_default());
    }
    let differ = colours.iter().zip(&QUANTITIES[1..]).filter(|((_, p), _)| *p < LEVEL);
    let words: Vec<String> =
        differ.map(|((mean, _), quantity)| format!("{} in {}", amount(mean), quantity.name())).collect();
    match (words.is_empty(), local) {
        (false, _) => format!("A is {}{without}{}", words.join(", "), local.map(around).unwrap_or_default()),
        (true, Some(local)) => format!(
            "A is {}{} around {}, p = {}; the mean of the image is within noise",
            amount(&local.estimate),
            in_colour(local.quantity),
            centre_of(&local),
            probability(local.p)
        ),
        (true, None) => of_pixels(difference, luminance),
    }
}

/// The verdict if only single pixels may differ.
fn of_pixels(difference: &Difference, luminance: &MeanDifference) -> String {
    let unseen = match &difference.pixels {
        Pixels::Shared { differing: 1, most } => return format!("A is {}, and all others are equal", of_pixel(most)),
        Pixels::Shared { differing, most } => {
            return format!(
                "A is {}, the most of {differing} pixels that differ; all others are equal",
                of_pixel(most)
            );
        }
        Pixels::Tested { most, .. } if most.p < LEVEL => {
            let p = probability(most.p);
            return format!("A is {}, p = {p}; the mean of the image is within noise", of_pixel(most));
        }
        Pixels::Tested { visible, .. } if visible.is_finite() => {
            let visible = with_error(100.0 * visible, f64::INFINITY);
            format!("; a single wrong pixel is noticed from {visible} % on")
        }
        Pixels::Tested { .. } => "; with so few samples, no single wrong pixel is noticed".to_string(),
        Pixels::Untested(Some(most)) if most.p < LEVEL => {
            let p = probability(most.p);
            return format!(
                "A is {} and differs along the edges as if it were shifted, p = {p}; the mean of the image is within noise",
                of_pixel(most)
            );
        }
        Pixels::Untested(Some(most)) => {
            let [x, y] = most.at;
            format!("; single pixels are not tested: the largest difference is {} in ({x}, {y})", size(most))
        }
        Pixels::Untested(None) => String::new(),
    };
    if luminance.difference.error.is_infinite() {
        return match luminance.difference.value == 0.0 {
            true => "A differs by noise only: both means are equal; the error of so few pixels is unknown".to_string(),
            false => {
                format!("A is {}; it may be noise, because so few pixels do not show their error", amount(luminance))
            }
        };
    }
    format!(
        "A differs by noise only, p = {}: less than {LEVEL} would be a difference{unseen}",
        probability(difference.p)
    )
}

/// "brighter by 9900 % in pixel (24, 39)", by the reference's value there.
fn of_pixel(single: &Single) -> String {
    let [x, y] = single.at;
    let direction = if single.difference < 0.0 { "darker" } else { "brighter" };
    format!("{direction} by {}{} in pixel ({x}, {y})", size(single), in_colour(single.quantity))
}

/// In percent of the reference there, if it is not black.
fn size(single: &Single) -> String {
    let share = single.difference.abs() / single.reference;
    match single.reference > 0.0 && share.is_finite() {
        true => format!("{} %", with_error(100.0 * share, f64::INFINITY)),
        false => with_error(single.difference.abs(), f64::INFINITY),
    }
}

fn in_colour(quantity: Quantity) -> String {
    match quantity {
        Quantity::Luminance => String::new(),
        colour => format!(" in {}", colour.name()),
    }
}

/// The middle pixel of a tile.
fn centre_of(local: &Local) -> String {
    let [left, top, width, height] = local.tile;
    format!("pixel ({}, {})", left + width / 2, top + height / 2)
}

/// "darker by 1.2 ± 0.1 %", relative to the reference's mean; "darker by 0.012 ± 0.001" if the reference is black.
fn amount(mean: &MeanDifference) -> String {
    let direction = if mean.difference.value < 0.0 { "darker" } else { "brighter" };
    let (size, half) = (mean.difference.value.abs(), mean.difference.half_width());
    match mean.reference > 0.0 {
        true => {
            let percent = 100.0 / mean.reference;
            format!("{direction} by {} %", with_error(size * percent, half * percent))
        }
        false => format!("{direction} by {}", with_error(size, half)),
    }
}

/// A number with its error. The error decides the number of decimals.
fn with_error(value: f64, error: f64) -> String {
    // Three digits of the value are enough if the error is tiny, two if it is unknown.
    let known = error.is_finite() && error > 0.0;
    let step = if known { error.max(value * 1e-3) } else { value * 1e-1 };
    if !(1e-6..1e9).contains(&step) {
        return if known { format!("{value:.3e} ± {error:.1e}") } else { format!("{value:.3e}") };
    }
    // Errors with a first digit of 1 have two digits, others one.
    let digits = -step.log10().floor() as i32;
    let digits = if step * 10f64.powi(digits) < 2.0 { digits + 1 } else { digits };
    let digits = usize::try_from(digits).unwrap_or(0);
    match error.is_finite() {
        true => format!("{value:.digits$} ± {error:.digits$}"),
        false => format!("{value:.digits$}"),
    }
}

/// A p-value with as many digits as a sentence needs.
fn probability(p: f64) -> String {
    match p {
        p if p >= 0.1 => format!("{p:.2}"),
        p if p >= 0.01 => format!("{p:.3}"),
        p if p >= 0.001 => format!("{p:.4}"),
        p if p >= 1e-99 => format!("{p:.0e}"),
        _ => "0".to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::difference::{ErrorSource, Means};
    use crate::metrics::estimate::Estimate;

    fn estimate(value: f64, error: f64) -> MeanDifference {
        MeanDifference { difference: Estimate { value, error, degrees: 1e6 }, reference: 0.5 }
    }

    fn nothing() -> Difference {
        Difference {
            source: ErrorSource::Variances,
            identical: false,
            means: [(estimate(0.0001, 0.0002), 0.9); 4],
            rest: None,
            local: None,
            pixels: Pixels::Untested(None),
            p: 0.412,
        }
    }

    #[test]
    fn verdicts_say_where_and_by_how_much_images_differ() {
        let of_mean = |mean: MeanDifference, p: f64| {
            let mut difference = nothing();
            difference.means[0] = (mean, p);
            difference
        };
        let darker = of_mean(estimate(-0.006, 0.000_5), 1e-30);
        let tile =
            Local { tile: [16, 32, 16, 15], quantity: Quantity::Red, estimate: estimate(0.05, 0.003), p: 3.21e-8 };
        let mut coloured = nothing();
        coloured.means[1] = (estimate(0.005, 0.000_1), 1e-9);
        coloured.means[3] = (estimate(-0.02, 0.001), 1e-9);
        let without = |pixels: usize, means: Means| Difference { rest: Some((pixels, means)), ..nothing() };
        let on_black = |error: f64| MeanDifference { reference: 0.0, ..estimate(0.02, error) };
        for (difference, words) in [
            (nothing(), "A differs by noise only, p = 0.41: less than 0.01 would be a difference"),
            (Difference { identical: true, ..nothing() }, "A differs by noise only, p = 1: the images are identical"),
            (darker.clone(), "A is darker by 1.20 ± 0.20 %"),
            (
                Difference { local: Some(tile), ..darker.clone() },
                "A is darker by 1.20 ± 0.20 %, most clearly around pixel (24, 39)",
            ),
            (
                Difference { local: Some(tile), ..nothing() },
                "A is brighter by 10.0 ± 1.2 % in red around pixel (24, 39), p = 3e-8; the mean of the image is within noise",
            ),
            (coloured.clone(), "A is brighter by 1.00 ± 0.04 % in red, darker by 4.0 ± 0.4 % in blue"),
            // If few pixels hold most of the noise, the verdict is about the others.
            (without(2, darker.means), "A is darker by 1.20 ± 0.20 % without the 2 pixels that hold most of the noise"),
            (
                without(1, coloured.means),
                "A is brighter by 1.00 ± 0.04 % in red, darker by 4.0 ± 0.4 % in blue without the pixel that holds most of the noise",
            ),
            // There are no percentages of a black reference, and single pixels have no error.
            (of_mean(on_black(0.001), 1e-9), "A is brighter by 0.0200 ± 0.0020"),
            (
                of_mean(on_black(f64::INFINITY), 1.0),
                "A is brighter by 0.020; it may be noise, because so few pixels do not show their error",
            ),
        ] {
            assert_eq!(verdict(&difference), words);
        }
    }

    #[test]
    fn verdicts_name_single_pixels() {
        let most = Single { at: [24, 39], quantity: Quantity::Luminance, difference: 49.5, reference: 0.5, p: 3.21e-8 };
        let of = |pixels: Pixels| verdict(&Difference { pixels, ..nothing() });
        assert_eq!(
            of(Pixels::Shared { differing: 1, most }),
            "A is brighter by 9900 % in pixel (24, 39), and all others are equal"
        );
        let red = Single { quantity: Quantity::Red, difference: -0.25, ..most };
        assert_eq!(
            of(Pixels::Shared { differing: 12, most: red }),
            "A is darker by 50 % in red in pixel (24, 39), the most of 12 pixels that differ; all others are equal"
        );
        assert_eq!(
            of(Pixels::Tested { most: Single { reference: 0.0, ..most }, visible: 0.3 }),
            "A is brighter by 50 in pixel (24, 39), p = 3e-8; the mean of the image is within noise"
        );
        assert_eq!(
            of(Pixels::Untested(Some(most))),
            "A is brighter by 9900 % in pixel (24, 39) and differs along the edges as if it were shifted, p = 3e-8; the mean of the image is \
             within noise"
        );
        // The sentence says from which difference on noise does not hide it.
        let noise = "A differs by noise only, p = 0.41: less than 0.01 would be a difference; ";
        let within = Single { p: 0.5, ..most };
        for (pixels, words) in [
            (Pixels::Tested { most: within, visible: 0.3456 }, "a single wrong pixel is noticed from 35 % on"),
            (
                Pixels::Tested { most: within, visible: f64::INFINITY },
                "with so few samples, no single wrong pixel is noticed",
            ),
            (
                Pixels::Untested(Some(within)),
                "single pixels are not tested: the largest difference is 9900 % in (24, 39)",
            ),
        ] {
            assert_eq!(of(pixels), format!("{noise}{words}"));
        }
    }

    #[test]
    fn numbers_of_any_size_can_be_said() {
        for value in [0.0, 1e-300, 1e-7, 0.003, 1.0, 99.96, 1e8, 1e20, 1e300] {
            for error in [0.0, 1e-300, 1e-6, 0.02, 7.0, 1e30, f64::INFINITY] {
                let text = with_error(value, error);
                assert!(text.len() < 40 && !text.contains("NaN"), "{value} {error}: {text}");
            }
        }
        let said = [1.0, 0.412, 0.0512, 0.004_12, 3.2e-7, 1e-200, 0.0].map(probability);
        assert_eq!(said, ["1.00", "0.41", "0.051", "0.0041", "3e-7", "0", "0"]);
    }
}

//! Spectra by wavelengths as linear Rec. 709 colours, by the standard observer: emissions as they are, and reflectances under D65, as the RGB variants of
//! Mitsuba have them. They have no black bodies; these are as in its spectral variants.

use std::path::Path;
use std::sync::LazyLock;

use glam::DVec4;

use super::tables;
use crate::scene::file;
use crate::scene::types::Colour;

/// The longest file of a spectrum, in bytes.
const LONGEST: u64 = 1 << 24;

/// The wavelengths of the table, in nanometres.
const FIRST: f64 = 360.0;
const LAST: f64 = 830.0;
const STEP: f64 = 5.0;

/// For each wavelength: the colour-matching functions x, y and z of the observer, and D65.
static OBSERVER: LazyLock<Vec<DVec4>> = LazyLock::new(|| {
    let rows = tables::rows(include_str!("observer.csv"));
    rows.filter_map(|numbers| Some(DVec4::from_array(numbers.try_into().ok()?))).collect()
});

/// The integral of Y, by which Mitsuba divides; and what a reflectance of 1 becomes there.
const WHOLE: f64 = 106.750_259_4;
const OF_ONE: f64 = 0.998_892;

/// A colour of values at wavelengths in nanometres, which rise. Between them the spectrum is linear, and beyond them 0.
pub fn of_pairs(pairs: &[(f64, f64)], is_emission: bool) -> Colour {
    let value = |at: f64| {
        let next = pairs.partition_point(|(wavelength, _)| *wavelength < at);
        match (next.checked_sub(1).and_then(|before| pairs.get(before)), pairs.get(next)) {
            (Some((from, a)), Some((to, b))) => a + (b - a) * (at - from) / (to - from),
            (None, Some((to, b))) if *to == at => *b,
            _ => 0.0,
        }
    };
    integral(value, is_emission)
}

/// The radiance of a black body of a temperature in kelvins, in W / (m² sr nm) (Planck's law).
pub fn of_black_body(kelvins: f64) -> Colour {
    // 2 h c² and h c / k.
    let (of_radiance, of_exponent) = (1.191_042_972e-16, 1.438_776_877e-2);
    let value = |nanometres: f64| {
        let metres = 1e-9 * nanometres;
        1e-9 * of_radiance / (metres.powi(5) * (of_exponent / (metres * kelvins)).exp_m1())
    };
    integral(value, true)
}

/// The values of a file at wavelengths, one of each a line.
pub fn pairs_of_file(path: &Path) -> Result<Vec<(f64, f64)>, String> {
    let bytes = file::read(path, "spectrum", LONGEST)?;
    let text = String::from_utf8_lossy(&bytes);
    let lines = text.lines().map(|line| line.split('#').next().unwrap_or_default().trim());
    let pair = |line: &str| {
        let (wavelength, value) = line.split_once(|c: char| c.is_ascii_whitespace() || c == ',')?;
        Some((wavelength.parse().ok()?, value.trim().parse().ok()?))
    };
    let pairs: Option<Vec<_>> = lines.filter(|line| !line.is_empty()).map(pair).collect();
    pairs
        .filter(|pairs| rise(pairs))
        .ok_or_else(|| format!("{}: expected a wavelength that rises and a value in each line", path.display()))
}

/// Whether these are finite values at wavelengths that rise.
pub fn rise(pairs: &[(f64, f64)]) -> bool {
    let finite = pairs.iter().all(|(wavelength, value)| wavelength.is_finite() && value.is_finite());
    finite && !pairs.is_empty() && pairs.is_sorted_by(|a, b| a.0 < b.0)
}

fn integral(value: impl Fn(f64) -> f64, is_emission: bool) -> Colour {
    const STEPS: u32 = 1000;
    let (mut sum, mut white) = (Colour::ZERO, 0.0);
    for step in 0..STEPS {
        let at = FIRST + (LAST - FIRST) * f64::from(step) / f64::from(STEPS - 1);
        let before = (((at - FIRST) / STEP) as usize).min(OBSERVER.len() - 2);
        let share = (at - FIRST) / STEP - before as f64;
        let [seen, next] = [before, before + 1].map(|row| OBSERVER[row]);
        let seen = seen + share * (next - seen);
        let light = if is_emission { 1.0 } else { seen.w };
        sum += value(at) * light * seen.truncate();
        white += light * seen.y;
    }
    let xyz = sum * if is_emission { (LAST - FIRST) / f64::from(STEPS) / WHOLE } else { OF_ONE / white };
    let channel = |x: f64, y: f64, z: f64| Colour::new(x, y, z).dot(xyz).max(0.0);
    Colour::new(
        channel(3.240479, -1.537150, -0.498535),
        channel(-0.969256, 1.875991, 0.041556),
        channel(0.055648, -0.204043, 1.057311),
    )
}

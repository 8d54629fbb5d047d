//! The checks of a render until an error.

use crate::data::RUN_LENGTH;
use crate::film::Film;

/// The checks of a render until an error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// The number of checks so far, with those of the renders that this one continues.
    pub checks: u32,
    /// Whether the bound was below the requested error.
    pub reached: bool,
}

/// The probability that a render until an error ends with a larger one, over all its checks.
pub const NOISE_LEVEL: f64 = 0.05;

/// The probability that a check, after so many earlier ones, is allowed to find the error below its bound by chance. The k-th check has the
/// share 1 / (k (k + 1)) of [`NOISE_LEVEL`], so that all together have at most that.
pub fn level_after(checks: u32) -> f64 {
    let number = f64::from(checks) + 1.0;
    NOISE_LEVEL / (number * (number + 1.0))
}

impl Noise {
    /// The probability of the last check ([`level_after`]).
    pub fn level(&self) -> f64 {
        level_after(self.checks.saturating_sub(1))
    }
}

/// The samples of a pixel at the first check of a render until an error.
pub const FIRST_CHECK: u32 = 2 * RUN_LENGTH;
/// The samples of a pixel from which on a render until an error gives up if more are of no use: the error has no bound, because pixels are
/// too few or have no light; or the noise is small, and paths still do not find light that is there.
pub const LAST_CHECK: u32 = 1 << 14;

/// The samples of a pixel at a check of the error, after `checks` earlier ones: 16, 32, 48, 64, then each quarter of a doubling. At a
/// check, the two halves of a pixel have the same number of samples.
pub fn samples_at_check(checks: u32) -> u32 {
    match checks.checked_sub(4) {
        None => FIRST_CHECK * (checks + 1),
        Some(later) => FIRST_CHECK.saturating_mul(5 + later % 4).saturating_mul(2u32.saturating_pow(later / 4)),
    }
}

/// Checks the error of a film with `samples` samples per pixel, after `checks` earlier checks. Returns the result, and whether the render ends.
pub fn check_error(film: &Film, samples: u32, checks: u32, error: f64) -> (Noise, bool) {
    let verdict = film.verdict(level_after(checks));
    let bound = verdict.error.map_or(f64::INFINITY, |found| found.bound);
    let noise = Noise { checks: checks.saturating_add(1), reached: bound < error && !verdict.lacks_light() };
    let is_hopeless = bound == f64::INFINITY || bound < error;
    (noise, noise.reached || (is_hopeless && samples >= LAST_CHECK))
}

//! Checks of numbers. Each error points at the number's own place.

use glam::DVec3;

use super::Place;
use crate::error::Result;

/// The largest magnitude of a number. Its square is finite in f64, with room for sums.
pub const LARGEST: f64 = 1e100;
/// The smallest length other than zero. Its square is a normal number.
pub const SMALLEST: f64 = 1e-100;
/// Directions whose angle has a sine below this count as parallel.
const SMALLEST_SINE: f64 = 1e-9;

/// Checks that a number is finite and can be squared.
pub fn number(at: &Place, x: f64) -> Result<()> {
    if x.abs() <= LARGEST {
        return Ok(());
    }
    Err(at.unexpected(format!("a finite number of at most {LARGEST:e} in magnitude")))
}

pub fn vector(at: &Place, v: DVec3) -> Result<()> {
    v.to_array().into_iter().enumerate().try_for_each(|(index, x)| number(&at.index(index), x))
}

/// Checks that a number is positive and can be squared.
pub fn length(at: &Place, what: &str, x: f64) -> Result<()> {
    if (SMALLEST..=LARGEST).contains(&x) {
        return Ok(());
    }
    let range = if x > 0.0 { format!("from {SMALLEST:e} to {LARGEST:e}") } else { "greater than 0".to_owned() };
    Err(at.unexpected(format!("{what} {range}")))
}

/// Whether two directions are parallel, whatever their lengths.
pub fn parallel(a: DVec3, b: DVec3) -> bool {
    let unit = |v: DVec3| (v / v.abs().max_element()).normalize();
    unit(a).cross(unit(b)).length() < SMALLEST_SINE
}

/// Checks that a number is from 0 to 1.
pub fn share(at: &Place, what: &str, x: f64) -> Result<()> {
    if (0.0..=1.0).contains(&x) {
        return Ok(());
    }
    Err(at.unexpected(format!("{what} from 0 to 1")))
}

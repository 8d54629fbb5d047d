//! Checks of numbers. Each error points at the number's own location.

use std::fmt;

use glam::DVec3;

use super::ValuePath;
use crate::error::Result;

pub const SCENE_UNITS: &str = "scene units";
pub const DEGREES: &str = "degrees";
pub const NO_UNIT: &str = "";

/// The largest magnitude of a number. Its square is finite in f64, with room for sums.
pub const LARGEST: f64 = 1e100;
/// The smallest length other than zero. Its square is a normal number.
pub const SMALLEST: f64 = 1e-100;
/// Directions whose angle has a sine below this count as parallel.
const SMALLEST_SINE: f64 = 1e-9;

/// A range of numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    least: f64,
    most: f64,
    has_ends: bool,
    /// Whether 0 is allowed too.
    or_zero: bool,
}

impl Range {
    /// What is finite and can be squared.
    pub const ANY: Range = Range::from_to(-LARGEST, LARGEST);
    /// What is positive and can be squared.
    pub const POSITIVE: Range = Range::from_to(SMALLEST, LARGEST);
    pub const NOT_NEGATIVE: Range = Range::POSITIVE.or_zero();
    pub const SHARE: Range = Range::from_to(0.0, 1.0);

    pub const fn from_to(least: f64, most: f64) -> Range {
        Range { least, most, has_ends: true, or_zero: false }
    }

    /// The numbers between these two, without the two.
    pub const fn between(least: f64, most: f64) -> Range {
        Range { has_ends: false, ..Range::from_to(least, most) }
    }

    pub const fn or_zero(self) -> Range {
        Range { or_zero: true, ..self }
    }

    pub fn holds(&self, x: f64) -> bool {
        let inside = if self.has_ends { self.least <= x && x <= self.most } else { self.least < x && x < self.most };
        inside || self.or_zero && x == 0.0
    }

    /// Refuses a number of this name and unit that is out of range.
    pub fn check(&self, at: &ValuePath, name: &str, unit: &str, x: f64) -> Result<()> {
        if self.holds(x) {
            return Ok(());
        }
        if *self == Range::ANY {
            return Err(at.unexpected(format!("a finite number of at most {LARGEST:e} in magnitude")));
        }
        let a = if name.starts_with(['a', 'e', 'i', 'o', 'u']) { "an" } else { "a" };
        let or = if self.or_zero { "of 0 or " } else { "" };
        let range = match self.least == SMALLEST && (x <= 0.0 || x.is_nan()) {
            true => "greater than 0".to_owned(),
            false => Range { or_zero: false, ..*self }.to_string(),
        };
        let unit = if unit == DEGREES { ", in degrees" } else { "" };
        Err(at.unexpected(format!("{a} {name} {or}{range}{unit}")))
    }

    /// Refuses a colour, a point or a vector with a number out of range.
    pub fn check_each(&self, at: &ValuePath, name: &str, v: DVec3) -> Result<()> {
        v.to_array().into_iter().enumerate().try_for_each(|(index, x)| self.check(&at.index(index), name, NO_UNIT, x))
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = |x: f64| match x.abs() {
            size if size != 0.0 && !(1e-4..1e5).contains(&size) => format!("{x:e}"),
            _ => x.to_string(),
        };
        let (least, most) = (text(self.least), text(self.most));
        let zero = if self.or_zero { "0 or " } else { "" };
        match self.has_ends {
            true => write!(f, "{zero}from {least} to {most}"),
            false => write!(f, "{zero}between {least} and {most}, both excluded"),
        }
    }
}

/// Whether two directions are parallel, whatever their lengths.
pub fn parallel(a: DVec3, b: DVec3) -> bool {
    let unit = |v: DVec3| (v / v.abs().max_element()).normalize();
    unit(a).cross(unit(b)).length() < SMALLEST_SINE
}

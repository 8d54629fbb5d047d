//! Colours of other primaries than Rec. 709, as an EXR's header may name them.

use exr::math::Vec2;
use exr::meta::attribute::Chromaticities;
use glam::{DMat3, DVec3};

use crate::data::Rgb;

/// Rec. 709 and its white D65 (ITU-R BT.709-6, items 1.3 and 1.4).
pub const REC_709: Chromaticities =
    Chromaticities { red: Vec2(0.64, 0.33), green: Vec2(0.3, 0.6), blue: Vec2(0.15, 0.06), white: Vec2(0.3127, 0.329) };

/// Chromaticities that differ by less are the same: files have them with three or four digits.
const SAME: f32 = 1e-3;

/// From XYZ to the responses of the cones, by Bradford (Lam, PhD thesis, University of Bradford, 1985; ICC.1:2022, annex E).
const BRADFORD: DMat3 = DMat3::from_cols(
    DVec3::new(0.8951, -0.7502, 0.0389),
    DVec3::new(0.2664, 1.7135, -0.0685),
    DVec3::new(-0.1614, 0.0367, 1.0296),
);

fn is_rec_709(given: &Chromaticities) -> bool {
    let all = |of: &Chromaticities| [of.red, of.green, of.blue, of.white];
    let near = |(a, b): (Vec2<f32>, Vec2<f32>)| (a.0 - b.0).abs() <= SAME && (a.1 - b.1).abs() <= SAME;
    all(given).into_iter().zip(all(&REC_709)).all(near)
}

/// XYZ of white, with Y = 1.
fn white(of: &Chromaticities) -> DVec3 {
    let [x, y] = [of.white.0, of.white.1].map(f64::from);
    DVec3::new(x, y, 1.0 - x - y) / y
}

/// The matrix to XYZ that takes (1, 1, 1) to white (SMPTE RP 177).
fn to_xyz(of: &Chromaticities) -> DMat3 {
    let column = |Vec2(x, y): Vec2<f32>| DVec3::new(f64::from(x), f64::from(y), 1.0 - f64::from(x) - f64::from(y));
    let primaries = DMat3::from_cols(column(of.red), column(of.green), column(of.blue));
    primaries * DMat3::from_diagonal(primaries.inverse() * white(of))
}

/// The conversion from the chromaticities of a file's header to Rec. 709; none if these are its own. A file that does not say so is taken to have
/// them. White stays white, by Bradford's adaptation.
///
/// # Errors
/// If they are no primaries of a colour space.
pub fn to_rec_709(known: Option<Chromaticities>) -> Result<Option<Conversion>, String> {
    let Some(of) = known.filter(|of| !is_rec_709(of)) else { return Ok(None) };
    let cones = BRADFORD * white(&REC_709) / (BRADFORD * white(&of));
    let adapted = BRADFORD.inverse() * DMat3::from_diagonal(cones) * BRADFORD;
    let matrix = to_xyz(&REC_709).inverse() * adapted * to_xyz(&of);
    // No primaries in use come near this; those on a line, or a white of no light, are beyond it or no numbers.
    match matrix.to_cols_array().iter().all(|v| v.abs() < 1e3) {
        true => Ok(Some(Conversion { of, matrix })),
        false => Err(format!("its chromaticities are no primaries of colours: {}", words(&of))),
    }
}

fn words(given: &Chromaticities) -> String {
    let of = |Vec2(x, y): Vec2<f32>| format!("({x}, {y})");
    let Chromaticities { red, green, blue, white } = *given;
    format!("red {}, green {}, blue {}, white {}", of(red), of(green), of(blue), of(white))
}

/// A conversion of colours to Rec. 709.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conversion {
    of: Chromaticities,
    matrix: DMat3,
}

impl Conversion {
    /// A colour of Rec. 709, which has negative parts if it is outside of Rec. 709. One that is not finite stays as it is.
    pub fn convert(&self, rgb: Rgb<f32>) -> Rgb<f32> {
        match rgb.iter().all(|v| v.is_finite()) {
            true => (self.matrix * DVec3::from_array(rgb.map(f64::from))).as_vec3().to_array(),
            false => rgb,
        }
    }

    /// What it converts from.
    pub fn words(&self) -> String {
        format!("its colours are converted to Rec. 709, from {}", words(&self.of))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn space([red, green, blue, white]: [(f32, f32); 4]) -> Chromaticities {
        let [red, green, blue, white] =
            [Vec2(red.0, red.1), Vec2(green.0, green.1), Vec2(blue.0, blue.1), Vec2(white.0, white.1)];
        Chromaticities { red, green, blue, white }
    }

    const ACES_CG: Chromaticities = space([(0.713, 0.293), (0.165, 0.83), (0.128, 0.044), (0.32168, 0.33767)]);
    const ACES: Chromaticities = space([(0.7347, 0.2653), (0.0, 1.0), (0.0001, -0.077), (0.32168, 0.33767)]);
    const XYZ: Chromaticities = space([(1.0, 0.0), (0.0, 1.0), (0.0, 0.0), (1.0 / 3.0, 1.0 / 3.0)]);

    fn close(found: Rgb<f32>, expected: Rgb<f32>, error: f32) {
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= error), "{found:?}, expected {expected:?}");
    }

    #[test]
    fn colours_convert_as_others_convert_them() {
        // The rows of ACEScg to linear Rec. 709 by Bradford, as OpenColorIO's ACES config has them.
        let conversion = to_rec_709(Some(ACES_CG)).unwrap().unwrap();
        close(conversion.convert([1.0, 0.0, 0.0]), [1.705_05, -0.130_26, -0.024_00], 1e-4);
        close(conversion.convert([0.0, 1.0, 0.0]), [-0.621_79, 1.140_80, -0.128_97], 1e-4);
        close(conversion.convert([0.0, 0.0, 1.0]), [-0.083_26, -0.010_55, 1.152_97], 1e-4);
        for space in [ACES_CG, ACES, XYZ] {
            close(to_rec_709(Some(space)).unwrap().unwrap().convert([0.18; 3]), [0.18; 3], 1e-6);
        }
    }

    #[test]
    fn rec_709_stays_and_no_primaries_are_refused() {
        assert_eq!(to_rec_709(Some(REC_709)), Ok(None));
        assert_eq!(to_rec_709(Some(Chromaticities { white: Vec2(0.3128, 0.3290), ..REC_709 })), Ok(None));
        for broken in [
            Chromaticities { red: REC_709.green, ..REC_709 },
            Chromaticities { white: Vec2(0.3, 0.0), ..REC_709 },
            Chromaticities { blue: Vec2(f32::NAN, 0.0), ..REC_709 },
            Chromaticities { red: Vec2(f32::INFINITY, 0.0), ..REC_709 },
        ] {
            assert!(to_rec_709(Some(broken)).is_err_and(|words| words.contains("no primaries")), "{broken:?}");
        }
        let conversion = to_rec_709(Some(ACES)).unwrap().unwrap();
        assert!(conversion.convert([f32::INFINITY, 1.0, 0.0])[0].is_infinite());
    }
}

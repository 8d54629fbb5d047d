//! The colours of a file, by the chromaticities in its header.

use ::exr::math::Vec2;
use ::exr::meta::attribute;
use ::exr::meta::header::Header;

use crate::chromaticities::{Chromaticities, Conversion, REC_709};

/// Those of Rec. 709, for a header.
pub(super) fn rec_709() -> attribute::Chromaticities {
    let of = |[x, y]: [f32; 2]| Vec2(x, y);
    let Chromaticities { red, green, blue, white } = REC_709;
    attribute::Chromaticities { red: of(red), green: of(green), blue: of(blue), white: of(white) }
}

/// The conversion of a file's colours to Rec. 709; none if they are of Rec. 709. A file that does not say so is taken to be.
///
/// # Errors
/// What is wrong with its chromaticities.
pub(super) fn to_rec_709(header: &Header) -> Result<Option<Conversion>, String> {
    let of = |Vec2(x, y): Vec2<f32>| [x, y];
    let known = header.shared_attributes.chromaticities.map(|known| Chromaticities {
        red: of(known.red),
        green: of(known.green),
        blue: of(known.blue),
        white: of(known.white),
    });
    known.map_or(Ok(None), Chromaticities::to_rec_709)
}

/// What is to be told of a file with such colours.
pub(super) fn note(conversion: &Result<Option<Conversion>, String>) -> Option<String> {
    match conversion {
        Ok(conversion) => conversion.as_ref().map(Conversion::words),
        Err(reason) => Some(format!("{reason}: its colours are taken for Rec. 709")),
    }
}

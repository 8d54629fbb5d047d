//! How directions are laid out on the image, as the scene file says it.

use std::f64::consts::{FRAC_PI_2, PI};

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::source::declare::declare;
use crate::source::form::{Checked, Field, Form, number, other};
use crate::source::{DEGREES, NO_UNIT, Range, SCENE_UNITS, ValuePath};

const PIXELS: &str = "pixels of the scene's image";
const FOCAL_LENGTH: Field = number(Range::POSITIVE, PIXELS);
const PIXEL: Field = number(Range::ANY, PIXELS);
/// Kernels compute its polynomial in f32.
const COEFFICIENT: Field = number(Range::from_to(-1e9, 1e9), NO_UNIT).or("0");

declare! {
    #[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
    #[serde(deny_unknown_fields)]
    pub enum Projection {
        /// A flat film, as that of most lenses. `vertical_fov` of the camera is its short form.
        Perspective: perspective, "Perspective(vertical_fov: 40)" {
            /// The angle between the upper and the lower edge of the image.
            vertical_fov: f64 = number(Range::between(0.0, 180.0), DEGREES);
        }
        /// Parallel rays. What is behind `look_from` is not seen.
        Orthographic: orthographic, "Orthographic(height: 4)" {
            /// The height of the image, in scene units.
            height: f64 = number(Range::POSITIVE, SCENE_UNITS);
        }
        /// A panorama: longitude to the right and latitude upwards, both from `look_at`.
        Equirectangular: equirectangular, "Equirectangular(horizontal: (-180, 180), vertical: (-90, 90))" {
            /// The longitudes of the left and of the right edge.
            #[serde(default = "whole_turn")]
            horizontal: (f64, f64) = other("two angles in degrees: (left, right)").or("(-180, 180)");
            /// The latitudes of the lower and of the upper edge.
            #[serde(default = "half_turn")]
            vertical: (f64, f64) = other("two angles in degrees: (bottom, top)").or("(-90, 90)");
        }
        /// A fisheye lens. Where its model has no direction, the image is black.
        Fisheye: fisheye, "Fisheye(model: Equidistant, fov: 180)" {
            /// The distance from the middle at an angle t to the axis: `Equidistant` t, `Equisolid` 2 sin(t/2), `Stereographic` 2 tan(t/2),
            /// `Orthographic` sin t.
            model: FisheyeModel = other("Equidistant, Equisolid, Stereographic or Orthographic");
            /// The angle between the upper and the lower edge: 360 at most, stereographic below that, orthographic 180 at most.
            fov: f64 = number(Range::POSITIVE, DEGREES);
        }
        /// A calibrated camera, with OpenCV's model of the lens. `--size` scales it.
        Calibrated: calibrated, "Calibrated(fx: 310, fy: 310, cx: 160, cy: 90)" {
            /// The focal length along x, in pixels of the scene's `image`.
            fx: f64 = FOCAL_LENGTH;
            /// The focal length along y.
            fy: f64 = FOCAL_LENGTH;
            /// Where the axis meets the image, from its left edge, as COLMAP and pbrt count. OpenCV counts from the middle of the first pixel:
            /// add 0.5.
            cx: f64 = PIXEL;
            /// The same from the upper edge.
            cy: f64 = PIXEL;
            /// What the lens does to the flat image.
            @default distortion: Option<Distortion> = other("Brown(k1: ..) or KannalaBrandt(k1: ..)").or("no distortion");
        }
    }
}

declare! {
    /// The distortion of a lens.
    #[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
    #[serde(deny_unknown_fields)]
    pub enum Distortion {
        /// OpenCV's radial and tangential distortion.
        Brown: brown, "Brown(k1: -0.2, k2: 0.05)" {
            @default k1: f64 = COEFFICIENT;
            @default k2: f64 = COEFFICIENT;
            @default p1: f64 = COEFFICIENT;
            @default p2: f64 = COEFFICIENT;
            @default k3: f64 = COEFFICIENT;
        }
        /// OpenCV's fisheye lens: t + k1 t³ + k2 t⁵ + k3 t⁷ + k4 t⁹ from the middle at the angle t.
        KannalaBrandt: kannala_brandt, "KannalaBrandt(k1: -0.02)" {
            @default k1: f64 = COEFFICIENT;
            @default k2: f64 = COEFFICIENT;
            @default k3: f64 = COEFFICIENT;
            @default k4: f64 = COEFFICIENT;
        }
    }
}

impl Checked for Distortion {}
impl Checked for Projection {}

/// How the distance r from the middle of a fisheye's image depends on the angle t to the axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum FisheyeModel {
    /// r = t
    Equidistant,
    /// r = 2 sin(t/2)
    Equisolid,
    /// r = 2 tan(t/2)
    Stereographic,
    /// r = sin t
    Orthographic,
}

impl Checked for FisheyeModel {}

impl FisheyeModel {
    /// r of an angle in radians.
    pub fn radius(self, angle: f64) -> f64 {
        match self {
            FisheyeModel::Equidistant => angle,
            FisheyeModel::Equisolid => 2.0 * (0.5 * angle).sin(),
            FisheyeModel::Stereographic => 2.0 * (0.5 * angle).tan(),
            FisheyeModel::Orthographic => angle.sin(),
        }
    }

    /// The largest angle that it shows.
    pub fn most_angle(self) -> f64 {
        if self == FisheyeModel::Orthographic { FRAC_PI_2 } else { PI }
    }
}

fn whole_turn() -> (f64, f64) {
    (-180.0, 180.0)
}

fn half_turn() -> (f64, f64) {
    (-90.0, 90.0)
}

impl Projection {
    /// The errors of what a form's numbers cannot say alone.
    pub fn errors(&self, at: &ValuePath) -> Vec<Error> {
        let at = &at.variant(self.name());
        let errors = self.check_fields(at);
        if !errors.is_empty() {
            return errors;
        }
        let angles = |name: &'static str, (from, to): (f64, f64), range: Range, most: f64| -> Result<()> {
            let at = at.field(name);
            range.check(&at.index(0), name, DEGREES, from)?;
            range.check(&at.index(1), name, DEGREES, to)?;
            match to > from && to - from <= most {
                true => Ok(()),
                false => Err(at.error(format!(
                    "expected the second angle of {name} above the first one, by {most} degrees at most, found ({from}, {to})"
                ))),
            }
        };
        let checks = match self {
            Projection::Equirectangular { horizontal, vertical } => vec![
                angles("horizontal", *horizontal, Range::from_to(-360.0, 360.0), 360.0),
                angles("vertical", *vertical, Range::from_to(-90.0, 90.0), 180.0),
            ],
            Projection::Fisheye { model, fov } => {
                let most = 2.0 * model.most_angle().to_degrees();
                let is_open = *model == FisheyeModel::Stereographic;
                let range = if is_open { Range::between(0.0, most) } else { Range::from_to(0.0, most) };
                vec![range.check(&at.field("fov"), &format!("fov of {model:?}"), DEGREES, *fov)]
            }
            Projection::Calibrated { distortion: Some(distortion), .. } => {
                let errors = distortion.check_fields(&at.field("distortion").variant(distortion.name()));
                errors.into_iter().map(Err).collect()
            }
            _ => Vec::new(),
        };
        checks.into_iter().filter_map(Result::err).collect()
    }
}

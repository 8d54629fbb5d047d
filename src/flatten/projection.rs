//! Where the film of a camera has which directions: as kernels compute it (shaders/camera), in f64.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use crate::data;
use crate::scene::{Camera, Distortion, FisheyeModel, ImageSize, Projection};

/// The film. Its points are in pixels from the image's middle, x to the right and y down; directions have the components right, down and forward.
#[derive(Clone, Debug)]
pub enum Film {
    /// A plane at distance 1, with pixels of this width.
    Plane { pixel: f64 },
    /// A plane across parallel rays, with pixels of this width in scene units.
    Parallel { pixel: f64 },
    /// Longitude and latitude in the image's middle, and how they change from one pixel to the next, in turns.
    Panorama { middle: DVec2, step: DVec2 },
    /// The change of r from one pixel to the next.
    Fisheye { model: FisheyeModel, step: f64 },
    /// `middle`: the principal point; `step`: 1 over the focal lengths; `fold`: the largest r².
    Brown { middle: DVec2, step: DVec2, radial: [f64; 3], tangential: [f64; 2], fold: f64 },
    /// `fold`: the largest angle.
    KannalaBrandt { middle: DVec2, step: DVec2, radial: [f64; 4], fold: f64 },
}

impl Film {
    /// The film of an image of `size` pixels. `image` is the size that the scene counts in.
    pub fn new(camera: &Camera, size: (u32, u32), image: ImageSize) -> Film {
        let extent = DVec2::new(f64::from(size.0), f64::from(size.1));
        // A mirrored camera looks to the left where others look to the right.
        let flip = if camera.mirror { -1.0 } else { 1.0 };
        match camera.projection() {
            Projection::Perspective { vertical_fov } => {
                Film::Plane { pixel: 2.0 * (0.5 * vertical_fov).to_radians().tan() / extent.y }
            }
            Projection::Orthographic { height } => Film::Parallel { pixel: height / extent.y },
            Projection::Equirectangular { horizontal: (left, right), vertical: (bottom, top) } => Film::Panorama {
                middle: DVec2::new(flip * 0.5 * (left + right), 0.5 * (bottom + top)) / 360.0,
                step: DVec2::new(right - left, bottom - top) / 360.0 / extent,
            },
            Projection::Fisheye { model, fov } => {
                Film::Fisheye { model, step: 2.0 * model.radius((0.5 * fov).to_radians()) / extent.y }
            }
            Projection::Calibrated { fx, fy, cx, cy, distortion } => {
                let scale = extent / DVec2::new(f64::from(image.width), f64::from(image.height));
                let middle = DVec2::new(cx, cy) * scale - 0.5 * extent;
                let middle = DVec2::new(flip * middle.x, middle.y);
                let step = 1.0 / (DVec2::new(fx, fy) * scale);
                match distortion.unwrap_or(Distortion::Brown { k1: 0.0, k2: 0.0, p1: 0.0, p2: 0.0, k3: 0.0 }) {
                    Distortion::Brown { k1, k2, p1, p2, k3 } => Film::Brown {
                        middle,
                        step,
                        radial: [k1, k2, k3],
                        tangential: [p1, flip * p2],
                        fold: first_root(&[1.0, 3.0 * k1, 5.0 * k2, 7.0 * k3], FARTHEST),
                    },
                    Distortion::KannalaBrandt { k1, k2, k3, k4 } => Film::KannalaBrandt {
                        middle,
                        step,
                        radial: [k1, k2, k3, k4],
                        fold: first_root(&[1.0, 3.0 * k1, 5.0 * k2, 7.0 * k3, 9.0 * k4], PI * PI).sqrt(),
                    },
                }
            }
        }
    }

    /// The fact of [`super::features::DECLARED`], unless it is a plane.
    pub fn fact(&self) -> Option<&'static str> {
        match self {
            Film::Plane { .. } => None,
            Film::Parallel { .. } => Some("projection.orthographic"),
            Film::Panorama { .. } => Some("projection.equirectangular"),
            Film::Fisheye { .. } => Some("projection.fisheye"),
            Film::Brown { .. } => Some("projection.calibrated"),
            Film::KannalaBrandt { .. } => Some("projection.calibrated_fisheye"),
        }
    }

    /// The least angle between neighbouring pixels, in radians; of parallel rays none.
    pub fn least_angle(&self) -> Option<f64> {
        match self {
            Film::Plane { pixel } => Some(*pixel),
            Film::Parallel { .. } => None,
            Film::Panorama { step, .. } => Some(TAU * step.abs().min_element()),
            Film::Fisheye { step, .. } => Some(*step),
            Film::Brown { step, .. } | Film::KannalaBrandt { step, .. } => Some(step.min_element()),
        }
    }

    /// The length of the vectors that kernels have for a pixel, where a scene unit is `scale`.
    pub fn pixel(&self, scale: f64) -> f64 {
        match self {
            Film::Plane { pixel } => *pixel,
            Film::Parallel { pixel } => pixel * scale,
            _ => 1.0,
        }
    }

    /// Writes the numbers that kernels have of it.
    pub fn write(&self, settings: &mut data::Settings) {
        let film = |a: DVec2, b: DVec2| [a.x, a.y, b.x, b.y].map(|x| x as f32);
        match self {
            Film::Plane { .. } | Film::Parallel { .. } => {}
            Film::Panorama { middle, step } => settings.film = film(*middle, *step),
            Film::Fisheye { step, .. } => settings.film = film(DVec2::ZERO, DVec2::splat(*step)),
            Film::Brown { middle, step, radial: [k1, k2, k3], tangential, fold } => {
                settings.film = film(*middle, *step);
                settings.distortion = [*k1, *k2, *k3, *fold].map(|x| x as f32);
                settings.tangential = tangential.map(|x| x as f32);
            }
            Film::KannalaBrandt { middle, step, radial, fold } => {
                settings.film = film(*middle, *step);
                settings.distortion = radial.map(|x| x as f32);
                settings.fold = *fold as f32;
            }
        }
    }

    /// The unit direction of a point of the film, if it has one. Of parallel rays it is forward.
    pub fn direction(&self, at: DVec2) -> Option<DVec3> {
        let around = |p: DVec2, angle: f64| {
            let (sine, cosine) = angle.sin_cos();
            (p.normalize_or_zero() * sine).extend(cosine)
        };
        match self {
            Film::Plane { pixel } => Some((*pixel * at).extend(1.0).normalize()),
            Film::Parallel { .. } => Some(DVec3::Z),
            Film::Panorama { middle, step } => {
                let (longitude, latitude) = (TAU * (*middle + at * *step)).into();
                let (sine, cosine) = latitude.sin_cos();
                Some(DVec3::new(cosine.abs() * longitude.sin(), -sine, cosine.abs() * longitude.cos()))
            }
            Film::Fisheye { model, step } => {
                let p = *step * at;
                model.angle(p.length()).map(|angle| around(p, angle))
            }
            Film::Brown { middle, step, fold, .. } => {
                let aim = (at - *middle) * *step;
                let mut p = aim;
                for _ in 0..64 {
                    let (found, [dx, mixed, dy]) = self.distorted(p)?;
                    let (rest, slope) = (aim - found, dx * dy - mixed * mixed);
                    let step = DVec2::new(dy * rest.x - mixed * rest.y, dx * rest.y - mixed * rest.x) / slope;
                    p += step;
                    if step.length() <= f64::EPSILON * p.length() {
                        break;
                    }
                }
                let (found, [dx, mixed, dy]) = self.distorted(p)?;
                let is_before = p.length_squared() <= *fold && dx * dy > mixed * mixed;
                (is_before && (found - aim).length() < 1e-6 * (1.0 + aim.length())).then(|| p.extend(1.0).normalize())
            }
            Film::KannalaBrandt { middle, step, fold, .. } => {
                let aim = (at - *middle) * *step;
                let (mut low, mut high) = (0.0, *fold);
                if self.distance(high)? < aim.length() {
                    return None;
                }
                for _ in 0..64 {
                    let half = 0.5 * (low + high);
                    *if self.distance(half)? < aim.length() { &mut low } else { &mut high } = half;
                }
                Some(around(aim, low))
            }
        }
    }

    /// The point of the film where a direction of any length, or for parallel rays a point, is seen.
    pub fn point(&self, p: DVec3) -> Option<DVec2> {
        let (across, forward) = (p.truncate(), p.z);
        let angle = across.length().atan2(forward);
        match self {
            Film::Plane { pixel } => (forward > 0.0).then(|| across / forward / *pixel),
            Film::Parallel { pixel } => (forward > 0.0).then(|| across / *pixel),
            Film::Panorama { middle, step } => {
                let turns = DVec2::new(p.x.atan2(forward), (-p.y).atan2(p.x.hypot(forward))) / TAU - *middle;
                Some(DVec2::new(turns.x - turns.x.round(), turns.y) / *step)
            }
            Film::Fisheye { model, step } => {
                let is_seen = *model != FisheyeModel::Orthographic || forward >= 0.0;
                is_seen.then(|| across.normalize_or_zero() * model.radius(angle) / *step)
            }
            Film::Brown { middle, step, fold, .. } => {
                let (found, [dx, mixed, dy]) = self.distorted(across / forward)?;
                let is_before = (across / forward).length_squared() <= *fold && dx * dy > mixed * mixed;
                (forward > 0.0 && is_before).then(|| found / *step + *middle)
            }
            Film::KannalaBrandt { middle, step, fold, .. } => {
                let r = self.distance(angle)?;
                (angle <= *fold).then(|| across.normalize_or_zero() * r / *step + *middle)
            }
        }
    }

    /// A way on the film; around the vertical axis of a panorama the shorter one.
    pub fn shortest(&self, way: DVec2) -> DVec2 {
        match self {
            Film::Panorama { step, .. } => DVec2::new(way.x - (way.x * step.x).round() / step.x, way.y),
            _ => way,
        }
    }

    /// A point at distance 1 as Brown's lens shows it, with the derivatives dx/dx, dx/dy = dy/dx, and dy/dy.
    fn distorted(&self, p: DVec2) -> Option<(DVec2, [f64; 3])> {
        let Film::Brown { radial: [k1, k2, k3], tangential: [p1, p2], .. } = self else { return None };
        let s = p.length_squared();
        let radial = 1.0 + s * (k1 + s * (k2 + s * k3));
        let slope = k1 + s * (2.0 * k2 + s * 3.0 * k3);
        let shift = DVec2::new(p2 * (s + 2.0 * p.x * p.x), p1 * (s + 2.0 * p.y * p.y));
        let point = radial * p + 2.0 * p.x * p.y * DVec2::new(*p1, *p2) + shift;
        let dx = radial + 2.0 * (p.x * p.x * slope + p1 * p.y + 3.0 * p2 * p.x);
        let dy = radial + 2.0 * (p.y * p.y * slope + 3.0 * p1 * p.y + p2 * p.x);
        Some((point, [dx, 2.0 * (p.x * p.y * slope + p1 * p.x + p2 * p.y), dy]))
    }

    /// The distance from the middle at which Kannala and Brandt's lens shows an angle.
    fn distance(&self, angle: f64) -> Option<f64> {
        let Film::KannalaBrandt { radial: [k1, k2, k3, k4], .. } = self else { return None };
        let s = angle * angle;
        Some(angle * (1.0 + s * (k1 + s * (k2 + s * (k3 + s * k4)))))
    }

    /// The share of the image that no direction belongs to, by the middles of pixels: of all, or of some million in large images.
    pub fn share_without_direction(&self, size: (u32, u32)) -> f64 {
        if matches!(self, Film::Plane { .. } | Film::Parallel { .. } | Film::Panorama { .. }) {
            return 0.0;
        }
        let stride = (f64::from(size.0) * f64::from(size.1) / 1e6).sqrt().ceil().max(1.0) as usize;
        let middle = 0.5 * DVec2::new(f64::from(size.0), f64::from(size.1));
        let (mut all, mut without) = (0u64, 0u64);
        for y in (0..size.1).step_by(stride) {
            for x in (0..size.0).step_by(stride) {
                let at = DVec2::new(f64::from(x), f64::from(y)) + 0.5 - middle;
                all += 1;
                without += u64::from(self.direction(at).is_none());
            }
        }
        without as f64 / all as f64
    }
}

/// The largest r² of a lens without a fold: kernels square it.
const FARTHEST: f64 = 1e12;

/// The first root of a polynomial between 0 and `end`, or `end`. The lowest coefficient comes first, and is positive.
fn first_root(polynomial: &[f64], end: f64) -> f64 {
    roots(polynomial, end).first().copied().unwrap_or(end)
}

/// The roots between 0 and `end` at which a polynomial changes its sign. Between those of its derivative it has one at most.
fn roots(polynomial: &[f64], end: f64) -> Vec<f64> {
    if polynomial.len() < 2 {
        return Vec::new();
    }
    let value = |x: f64| polynomial.iter().rev().fold(0.0, |sum, coefficient| sum * x + coefficient);
    let derivative: Vec<f64> = (1u32..).zip(&polynomial[1..]).map(|(power, c)| f64::from(power) * c).collect();
    let mut ends = vec![0.0];
    ends.extend(roots(&derivative, end));
    ends.push(end);
    let root = |pair: &[f64]| {
        let (mut low, mut high) = (pair[0], pair[1]);
        if (value(low) < 0.0) == (value(high) < 0.0) {
            return None;
        }
        for _ in 0..200 {
            let half = 0.5 * (low + high);
            *if (value(half) < 0.0) == (value(low) < 0.0) { &mut low } else { &mut high } = half;
        }
        Some(low)
    };
    ends.windows(2).filter_map(root).collect()
}

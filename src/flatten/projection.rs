//! Where the film of a camera has which directions: as kernels compute it (shaders/camera), in f64.

use std::f64::consts::{PI, TAU};

use glam::{DMat2, DVec2, DVec3};

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
    /// A lens that shows angles to its axis at distances from it. `middle`: where the axis meets the film; `step`: how the distance changes from
    /// one pixel to the next; `most`: the largest angle.
    Round { lens: Lens, middle: DVec2, step: DVec2, most: f64 },
    /// The same of distances on a plane at distance 1, and a tangential distortion beside it.
    Brown { lens: Brown, middle: DVec2, step: DVec2, most: f64 },
}

/// A lens that is the same around its axis.
#[derive(Clone, Copy, Debug)]
pub enum Lens {
    Fisheye(FisheyeModel),
    /// x + k1 x³ + k2 x⁵ + k3 x⁷ + k4 x⁹ (shaders/camera/radial).
    Radial([f64; 4]),
}

impl Lens {
    /// The distance from the axis at which it shows an angle.
    fn distance(self, angle: f64) -> f64 {
        let s = angle * angle;
        match self {
            Lens::Fisheye(model) => model.radius(angle),
            Lens::Radial([k1, k2, k3, k4]) => angle * (1.0 + s * (k1 + s * (k2 + s * (k3 + s * k4)))),
        }
    }
}

/// The distortion of Brown, radial and tangential (shaders/camera/calibrated).
#[derive(Clone, Copy, Debug)]
pub struct Brown([f64; 4], [f64; 2]);

impl Brown {
    /// A point at distance 1 as it shows it, with the derivatives.
    fn distorted(&self, p: DVec2) -> (DVec2, DMat2) {
        let Brown([k1, k2, k3, _], [p1, p2]) = self;
        let s = p.length_squared();
        let radial = 1.0 + s * (k1 + s * (k2 + s * k3));
        let slope = k1 + s * (2.0 * k2 + s * 3.0 * k3);
        let shift = DVec2::new(p2 * (s + 2.0 * p.x * p.x), p1 * (s + 2.0 * p.y * p.y));
        let point = radial * p + 2.0 * p.x * p.y * DVec2::new(*p1, *p2) + shift;
        let mixed = 2.0 * (p.x * p.y * slope + p1 * p.x + p2 * p.y);
        let dx = radial + 2.0 * (p.x * p.x * slope + p1 * p.y + 3.0 * p2 * p.x);
        let dy = radial + 2.0 * (p.y * p.y * slope + 3.0 * p1 * p.y + p2 * p.x);
        (point, DMat2::from_cols_array(&[dx, mixed, mixed, dy]))
    }

    /// The same where the image is not folded.
    fn shown(&self, p: DVec2, fold: f64) -> Option<DVec2> {
        let (point, slopes) = self.distorted(p);
        (p.length() <= fold && slopes.determinant() > 0.0).then_some(point)
    }

    /// Whether it shows a point here.
    fn shows(&self, aim: DVec2, fold: f64) -> bool {
        let distance = |r: f64| Lens::Radial(self.0).distance(r) - aim.length();
        let mut p = root(distance, -fold, fold).unwrap_or(fold) * aim.normalize_or_zero();
        for _ in 0..8 {
            let (found, slopes) = self.distorted(p);
            p += slopes.inverse() * (aim - found);
        }
        self.shown(p, fold).is_some_and(|found| (found - aim).length() < 1e-6 * (1.0 + aim.length()))
    }
}

impl Film {
    /// The film of an image of `size` pixels. `image` is the size that the scene counts in.
    pub fn new(camera: &Camera, size: (u32, u32), image: ImageSize) -> Film {
        let extent = DVec2::new(f64::from(size.0), f64::from(size.1)) / camera.middle.unwrap_or(DVec2::ONE);
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
            Projection::Fisheye { model, fov } => Film::Round {
                lens: Lens::Fisheye(model),
                middle: DVec2::ZERO,
                step: DVec2::splat(2.0 * model.radius((0.5 * fov).to_radians()) / extent.y),
                most: model.most_angle(),
            },
            Projection::Calibrated { fx, fy, cx, cy, distortion } => {
                let scale = extent / DVec2::new(f64::from(image.width), f64::from(image.height));
                let middle = DVec2::new(cx, cy) * scale - 0.5 * extent;
                let middle = DVec2::new(flip * middle.x, middle.y);
                let step = 1.0 / (DVec2::new(fx, fy) * scale);
                let fold = |[k1, k2, k3, k4]: [f64; 4], most: f64| {
                    first_root(&[1.0, 3.0 * k1, 5.0 * k2, 7.0 * k3, 9.0 * k4], most * most).sqrt()
                };
                match distortion.unwrap_or(Distortion::Brown { k1: 0.0, k2: 0.0, p1: 0.0, p2: 0.0, k3: 0.0 }) {
                    Distortion::Brown { k1, k2, p1, p2, k3 } => {
                        let radial = [k1, k2, k3, 0.0];
                        let (lens, most) = (Brown(radial, [p1, flip * p2]), fold(radial, FARTHEST));
                        Film::Brown { lens, middle, step, most }
                    }
                    Distortion::KannalaBrandt { k1, k2, k3, k4 } => {
                        let radial = [k1, k2, k3, k4];
                        Film::Round { lens: Lens::Radial(radial), middle, step, most: fold(radial, PI) }
                    }
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
            Film::Round { lens: Lens::Fisheye(_), .. } => Some("projection.fisheye"),
            Film::Round { .. } => Some("projection.calibrated_fisheye"),
            Film::Brown { .. } => Some("projection.calibrated"),
        }
    }

    /// The least angle between neighbouring pixels, in radians; of parallel rays none.
    pub fn least_angle(&self) -> Option<f64> {
        match self {
            Film::Plane { pixel } => Some(*pixel),
            Film::Parallel { .. } => None,
            Film::Panorama { step, .. } => Some(TAU * step.abs().min_element()),
            Film::Round { step, .. } | Film::Brown { step, .. } => Some(step.min_element()),
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
        use Film::{Brown as OfBrown, Panorama, Round};
        if let Panorama { middle, step } | Round { middle, step, .. } | OfBrown { middle, step, .. } = self {
            settings.film = [middle.x, middle.y, step.x, step.y].map(|x| x as f32);
        }
        if let Round { lens: Lens::Radial(radial), most, .. } | OfBrown { lens: Brown(radial, _), most, .. } = self {
            (settings.distortion, settings.fold) = (radial.map(|x| x as f32), *most as f32);
        }
        if let OfBrown { lens: Brown(_, tangential), .. } = self {
            settings.tangential = tangential.map(|x| x as f32);
        }
    }

    /// Whether a point of the film has a direction.
    fn has_direction(&self, at: DVec2) -> bool {
        match self {
            Film::Plane { .. } | Film::Parallel { .. } | Film::Panorama { .. } => true,
            Film::Round { lens, middle, step, most } => ((at - *middle) * *step).length() <= lens.distance(*most),
            Film::Brown { lens, middle, step, most } => lens.shows((at - *middle) * *step, *most),
        }
    }

    /// The point of the film where a direction of any length, or for parallel rays a point, is seen.
    pub fn point(&self, p: DVec3) -> Option<DVec2> {
        let (across, forward) = (p.truncate(), p.z);
        match self {
            Film::Plane { pixel } => (forward > 0.0).then(|| across / forward / *pixel),
            Film::Parallel { pixel } => (forward > 0.0).then(|| across / *pixel),
            Film::Panorama { middle, step } => {
                let turns = DVec2::new(p.x.atan2(forward), (-p.y).atan2(p.x.hypot(forward))) / TAU - *middle;
                Some(DVec2::new(turns.x - turns.x.round(), turns.y) / *step)
            }
            Film::Round { lens, middle, step, most } => {
                let angle = across.length().atan2(forward);
                (angle <= *most).then(|| across.normalize_or_zero() * lens.distance(angle) / *step + *middle)
            }
            Film::Brown { lens, middle, step, most } if forward > 0.0 => {
                Some(lens.shown(across / forward, *most)? / *step + *middle)
            }
            Film::Brown { .. } => None,
        }
    }

    /// The width on the film of a whole turn around the vertical axis; 0 where the film has an edge there.
    pub fn turn(&self) -> f64 {
        if let Film::Panorama { step, .. } = self { 1.0 / step.x } else { 0.0 }
    }

    /// A way on the film; around the vertical axis of a panorama the shorter one.
    pub fn shortest(&self, way: DVec2) -> DVec2 {
        let turn = self.turn();
        if turn > 0.0 { DVec2::new(way.x - turn * (way.x / turn).round(), way.y) } else { way }
    }

    /// The share of the image that no direction belongs to, by the middles of pixels: of all, or of some million in large images.
    pub fn share_without_direction(&self, size: (u32, u32)) -> f64 {
        if !matches!(self, Film::Round { .. } | Film::Brown { .. }) {
            return 0.0;
        }
        let stride = (f64::from(size.0) * f64::from(size.1) / 1e6).sqrt().ceil().max(1.0) as usize;
        let middle = 0.5 * DVec2::new(f64::from(size.0), f64::from(size.1));
        let of_row = |y: u32| (0..size.0).step_by(stride).map(move |x| DVec2::new(f64::from(x), f64::from(y)));
        let points = || (0..size.1).step_by(stride).flat_map(of_row);
        let without = points().filter(|at| !self.has_direction(*at + 0.5 - middle)).count();
        without as f64 / points().count() as f64
    }
}

/// The largest distance of a lens without a fold.
const FARTHEST: f64 = 1e6;

/// The first root of a polynomial between 0 and `end`, or `end`. The lowest coefficient comes first, and is positive.
fn first_root(polynomial: &[f64], end: f64) -> f64 {
    roots(polynomial, end).first().copied().unwrap_or(end)
}

/// The roots between 0 and `end` at which a polynomial changes its sign. Between those of its derivative it has one at most.
fn roots(polynomial: &[f64], end: f64) -> Vec<f64> {
    let Some((_, rest)) = polynomial.split_first().filter(|(_, rest)| !rest.is_empty()) else { return Vec::new() };
    let value = |x: f64| polynomial.iter().rev().fold(0.0, |sum, coefficient| sum * x + coefficient);
    let derivative: Vec<f64> = (1u32..).zip(rest).map(|(power, c)| f64::from(power) * c).collect();
    let ends = [vec![0.0], roots(&derivative, end), vec![end]].concat();
    ends.windows(2).filter_map(|pair| root(value, pair[0], pair[1])).collect()
}

/// Where a function changes its sign between two numbers, if it does so once.
fn root(value: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> Option<f64> {
    let is_negative = value(low) < 0.0;
    if is_negative == (value(high) < 0.0) {
        return None;
    }
    for _ in 0..200 {
        let half = 0.5 * (low + high);
        *if (value(half) < 0.0) == is_negative { &mut low } else { &mut high } = half;
    }
    Some(low)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::scene::Scene;

    /// The film of an image's middle is the middle of the image's film.
    #[test]
    fn the_middle_of_an_image_shows_what_the_image_shows() {
        for projection in [
            "vertical_fov: 40",
            "projection: Orthographic(height: 3)",
            "projection: Equirectangular(horizontal: (-100, 60), vertical: (-30, 90))",
            "projection: Fisheye(model: Equisolid, fov: 160)",
            "projection: Calibrated(fx: 18, fy: 15, cx: 17, cy: 8, distortion: Brown(k1: -0.2, p2: 0.01))",
            "projection: Calibrated(fx: 9, fy: 9, cx: 16, cy: 9, distortion: KannalaBrandt(k1: -0.02))",
        ] {
            let text = format!(
                "Scene(image: (width: 32, height: 18), camera: (look_from: (0, 0, 0), look_at: (0, 0, -1), {projection}),
                background: Solid((0, 0, 0)), materials: {{}}, objects: [])"
            );
            let scene = Scene::parse(&text, Path::new("test.ron")).unwrap();
            let whole = Film::new(&scene.camera, (64, 36), scene.image);
            let middle = Some(DVec2::new(0.5, 1.0 / 3.0));
            let part = Film::new(&Camera { middle, ..scene.camera.clone() }, (32, 12), scene.image);
            for direction in [DVec3::new(0.1, -0.05, 1.0), DVec3::new(-0.2, 0.3, 1.1)] {
                let (all, own) = (whole.point(direction).unwrap(), part.point(direction).unwrap());
                assert!((all - own).length() < 1e-12 * all.length(), "{projection}: {all} {own}");
                let wrong = Film::new(&scene.camera, (32, 12), scene.image).point(direction).unwrap();
                assert!((all - wrong).length() > 0.1 * all.length(), "{projection}");
            }
        }
    }
}

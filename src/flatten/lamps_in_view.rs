//! Projects the lamps that the camera may see onto the image: how much of each pixel they cover while the shutter is open, over the lens and
//! the filter. Nothing hides them here.
//!
//! The film learns from it how bright a sample may be that has not come yet (docs/light-transport.md, "The bound of the error").

use std::collections::HashMap;
use std::f64::consts::PI;

use glam::{DMat3, DVec2, DVec3};

use super::coverage::{Coverage, clip};
use super::finder::{Finder, Primitive};
use super::motion::MotionStep;
use super::projection::Film;
use super::view::View;
use crate::data::{LampPixel, Rgb};
use crate::material::Emitted;
use crate::options::Filter;
use crate::scene::Scene;
use crate::shape::similarity::Similarity;
use crate::shape::{Cuboid, Geometry, KINDS, ObjectTransform, RenderSpace};

/// About so many cells are computed for all lamps together: pixels, or parts of them.
const MOST_CELLS: usize = 1 << 21;
/// Views of a lamp that moves or is out of focus: times, each with a point of the lens.
const LEAST_VIEWS: usize = 16;
const MOST_VIEWS: usize = 1 << 11;
/// Cells of a pixel along each axis if the filter is wider than the pixel, and how far filters reach from the pixel's middle, in pixels.
const CELLS: u32 = 4;
const REACH: f64 = 2.0;
/// Corners of the polygon in the place of a circle where lamps are few, and where they are many.
const CORNERS: [u32; 2] = [128, 12];
const MANY: usize = 1 << 12;
/// The image has no noise by a lamp in a pixel that it covers by more than this.
const COVERED: f32 = 0.999;

/// The part of each pixel that lamps cover, in the order of the pixels. `radiance_scale` takes radiance to device units.
pub fn lamps_in_view(
    scene: &Scene,
    view: &View<'_>,
    filter: Filter,
    finder: &Finder<'_>,
    emissions: &[Emitted],
    radiance_scale: f64,
) -> Vec<LampPixel> {
    let emissions = scene.materials.iter().zip(emissions).map(|((_, material), emitted)| {
        let emission = material.model().emission().filter(|_| emitted.is_seen())?;
        let radiance: DVec3 = radiance_scale * emission.slot.texture.largest_channels(&scene.bitmaps);
        (radiance.max_element() > 0.0).then_some((radiance, emission.two_sided))
    });
    let emissions: Vec<_> = emissions.collect();
    let lamps = finder.primitives.iter().filter_map(|primitive| {
        let (radiance, two_sided) = emissions[primitive.material as usize]?;
        Some(Lamp { primitive, radiance, two_sided })
    });
    let lamps: Vec<Lamp<'_>> = lamps.collect();
    if lamps.is_empty() {
        return Vec::new();
    }
    let shutter = scene.camera.shutter;
    let is_moving = !scene.camera.moving.is_empty() && shutter.0 < shutter.1;
    let several = is_moving || view.lens_radius() > 0.0;
    let eyes =
        (0..if several { MOST_VIEWS } else { 1 }).map(|number| Eye::new(scene, view, Moment::new(number, several)));
    let mut projection = Projection {
        eyes: eyes.collect(),
        size: view.size,
        filter,
        cells: (MOST_CELLS / lamps.len()).max(64),
        is_many: lamps.len() > MANY,
        pixels: HashMap::new(),
    };
    (0..).zip(&lamps).for_each(|(number, lamp)| projection.add(lamp, number));
    let finish = |mut found: LampPixel| {
        // Lamps that are behind each other cover a pixel but once.
        let part = 1.0 / found.share.max(1.0);
        found.share *= part;
        found.mean = found.mean.map(|x| x * part);
        found.square = found.square.map(|x| x * part);
        (found.share < COVERED).then_some(found)
    };
    let mut pixels: Vec<LampPixel> = projection.pixels.into_values().filter_map(finish).collect();
    pixels.sort_by_key(|found| (found.pixel, found.count as u32));
    pixels
}

/// A primitive that emits, with the largest radiance of its channels.
struct Lamp<'a> {
    primitive: &'a Primitive<'a>,
    radiance: DVec3,
    two_sided: bool,
}

/// A time from 0 to 1 while the shutter is open, and a point of a lens of radius 1.
struct Moment {
    time: f64,
    lens: DVec2,
}

impl Moment {
    /// One of several that are spread evenly; or the first moment, in the middle of the lens. The sequence is Roberts' ("The unreasonable
    /// effectiveness of quasirandom sequences", 2018): multiples of powers of 1/g, with g⁴ = g + 1.
    fn new(number: usize, several: bool) -> Moment {
        const STEPS: [f64; 3] = [0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_970_3];
        let [time, area, turn] = STEPS.map(|step| (0.5 + step * number as f64).fract());
        match several {
            true => Moment { time, lens: area.sqrt() * DVec2::from_angle(2.0 * PI * turn) },
            false => Moment { time: 0.0, lens: DVec2::ZERO },
        }
    }
}

/// The camera at a moment.
struct Eye {
    position: DVec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    /// How far the lens shifts what is seen, as directions of depth 1.
    shift: DVec2,
    film: Film,
    /// How far the position is behind the plane from which parallel rays start: so far that they are parallel.
    behind: f64,
    /// The middle of the image, in pixels.
    middle: DVec2,
}

/// So straight are edges on the film, in pixels, in a single view.
const STRAIGHT: f64 = 0.02;
/// So often may a triangle be halved along its edges where this makes none of its points seen.
const BLIND_HALVINGS: u32 = 4;

impl Eye {
    fn new(scene: &Scene, view: &View<'_>, Moment { time, lens }: Moment) -> Eye {
        let (open, close) = scene.camera.shutter;
        let camera = scene.camera.at(open + time * (close - open));
        let now = View::new(&camera, view.size, scene.image);
        // Each view has its own space; this is that of the first moment.
        let axes = view.to_space.rotation * (now.to_space.rotation.transpose() * now.axes);
        let focus = camera.focus_distance.unwrap_or((camera.look_at - camera.look_from).length());
        let lens = now.lens_radius() * lens;
        let behind = match view.film {
            Film::Parallel { pixel } => 1e6 * pixel * f64::from(view.size.1),
            _ => 0.0,
        };
        Eye {
            behind,
            position: view.to_space.point(camera.look_from)
                + lens.x * axes.x_axis
                + lens.y * axes.y_axis
                + behind * axes.z_axis,
            right: if camera.mirror { -axes.x_axis } else { axes.x_axis },
            up: axes.y_axis,
            forward: -axes.z_axis,
            shift: lens / focus,
            film: view.film.clone(),
            middle: 0.5 * DVec2::new(f64::from(view.size.0), f64::from(view.size.1)),
        }
    }

    /// The transform of an object to a space around the eye.
    fn sees<'a>(&self, to_world: &'a Similarity) -> ObjectTransform<'a> {
        ObjectTransform { to_world, space: RenderSpace { eye: self.position, scale: 1.0 } }
    }

    /// The distance of a point before the camera.
    fn depth(&self, p: DVec3) -> f64 {
        p.dot(self.forward) - self.behind
    }

    /// The point of the film, in pixels, of a point relative to the eye.
    fn project(&self, p: DVec3) -> Option<DVec2> {
        let forward = self.depth(p);
        let shift = forward * self.shift;
        let seen = DVec3::new(p.dot(self.right) + shift.x, -p.dot(self.up) - shift.y, forward);
        self.film.point(seen).map(|at| self.middle + at).filter(|at| at.is_finite())
    }

    /// The part of the film that may show a ball, by points of its outline: its lowest and highest coordinates, within the image and what filters
    /// reach around it.
    fn bounds(&self, center: DVec3, radius: f64) -> Option<(DVec2, DVec2)> {
        let (least, most) = (DVec2::splat(-REACH), 2.0 * self.middle + REACH);
        if matches!(self.film, Film::Plane { .. } | Film::Parallel { .. }) && self.depth(center) <= -radius {
            return None;
        }
        let (sine, axis) = (radius / center.length(), center / center.length());
        let (u, v) = axis.any_orthonormal_pair();
        let start = self.project(center);
        let at = |turn: u32| {
            let (s, c) = (0.25 * PI * f64::from(turn)).sin_cos();
            self.seen_beside(start, center + radius / (1.0 - sine * sine).sqrt() * (c * u + s * v))
        };
        let seen: Option<Vec<DVec2>> = (0..8).map(at).collect();
        // A panorama shows a pole along a whole edge.
        let may_have_pole = self.film.turn() > 0.0 && axis.dot(self.up).abs() > 0.9 - sine;
        let Some(seen) = seen.filter(|_| sine < 1.0 && !may_have_pole) else { return Some((least, most)) };
        let (low, high) = seen.iter().fold((seen[0], seen[0]), |(low, high), p| (low.min(*p), high.max(*p)));
        // Between two of the points an ellipse is up to 8 % farther out.
        let around = 1.0 + 0.1 * (high - low);
        let (mut min, mut max) = ((low - around).max(least), (high + around).min(most));
        // What is beyond the seam is seen at the other side.
        if self.film.turn() > 0.0 && (low.x < 0.0 || high.x > 2.0 * self.middle.x) {
            (min.x, max.x) = (least.x, most.x);
        }
        (min.x < max.x && min.y < max.y).then_some((min, max))
    }

    /// The point of the film that shows `p`. A panorama shows its left edge at its right one, too: the point that is nearer to `start`.
    fn seen_beside(&self, start: Option<DVec2>, p: DVec3) -> Option<DVec2> {
        Some(start? + self.film.shortest(self.project(p)? - start?))
    }

    /// A polygon as polygons on the film, within the image and what filters reach around it. Their edges are straight to this, in pixels.
    fn polygons(&self, corners: &[DVec3], straight: f64, add: &mut dyn FnMut(&[DVec2])) {
        match self.film {
            Film::Plane { .. } | Film::Parallel { .. } => {
                let farthest = corners.iter().map(|p| p.length()).fold(0.0, f64::max);
                let before = clip(corners, |p| self.depth(p) - 1e-9 * (farthest - self.behind));
                add(&self.within(&before.into_iter().filter_map(|p| self.project(p)).collect::<Vec<_>>()));
            }
            _ => {
                let Some((first, others)) = corners.split_first() else { return };
                others.windows(2).for_each(|pair| self.halve([*first, pair[0], pair[1]], 0, straight, add));
            }
        }
    }

    /// The part of a polygon that is within the image and what filters reach around it.
    fn within(&self, seen: &[DVec2]) -> Vec<DVec2> {
        let far = 2.0 * self.middle + REACH;
        let seen = clip(&clip(seen, |p| p.x + REACH), |p| p.y + REACH);
        clip(&clip(&seen, |p| far.x - p.x), |p| far.y - p.y)
    }

    /// A triangle as triangles whose edges are straight on a film that bends lines. At the end of the film, some are left out.
    fn halve(&self, corners: [DVec3; 3], halvings: u32, straight: f64, add: &mut dyn FnMut(&[DVec2])) {
        let [a, b, c] = corners;
        let middles = [0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)];
        let start = self.project(a);
        let seen = corners.map(|p| self.seen_beside(start, p));
        let between = middles.map(|p| self.seen_beside(start, p));
        let is_straight = |i: usize| {
            let (Some(from), Some(half), Some(to)) = (seen[i], between[i], seen[(i + 1) % 3]) else { return false };
            half.distance(0.5 * (from + to)) < straight && corners[i].angle_between(corners[(i + 1) % 3]) < 1.0
        };
        if let ([Some(a), Some(b), Some(c)], true) = (seen, (0..3).all(is_straight)) {
            for turns in if self.film.turn() > 0.0 { -1..=1 } else { 0..=0 } {
                add(&self.within(&[a, b, c].map(|p| p + DVec2::new(f64::from(turns) * self.film.turn(), 0.0))));
            }
            return;
        }
        // What is left at last is at the end of the film, or around the one point of a fisheye that is a circle there.
        let is_outside = || corners.into_iter().chain(middles).all(|p| self.project(p).is_none());
        let most = f64::from(BLIND_HALVINGS) + (1.0 / straight).log2().max(0.0);
        if f64::from(halvings) > most || (halvings >= BLIND_HALVINGS && is_outside()) {
            return;
        }
        let [ab, bc, ca] = middles;
        let parts = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]];
        parts.into_iter().for_each(|part| self.halve(part, halvings + 1, straight, add));
    }
}

struct Projection {
    /// The camera at all moments; once if it always sees the same of what rests.
    eyes: Vec<Eye>,
    size: (u32, u32),
    filter: Filter,
    /// So many cells may be computed for a lamp.
    cells: usize,
    is_many: bool,
    /// By the pixel, and by how many it stands for.
    pixels: HashMap<(u32, usize), LampPixel>,
}

impl Projection {
    /// Adds a lamp, which has this number.
    fn add(&mut self, lamp: &Lamp<'_>, number: u32) {
        let Primitive { shape, to_world, motion, .. } = lamp.primitive;
        let several = self.eyes.len() > 1 || !motion.is_empty();
        let eye = |view: usize| &self.eyes[if self.eyes.len() > 1 { view } else { 0 }];
        let pose = |view: usize| at_time(to_world, motion, Moment::new(view, several).time);
        let bounds = |view: usize| {
            let (center, radius) = shape.bounding_shape(&eye(view).sees(&pose(view))).ball();
            eye(view).bounds(center, radius)
        };
        // The cells of one view: the largest of some.
        let first = 0..if several { LEAST_VIEWS } else { 1 };
        let area = first.filter_map(bounds).map(|(min, max)| (max - min + 1.0).element_product()).fold(0.0, f64::max);
        let cells_of_pixel = match self.filter {
            Filter::Box => 1,
            _ if area * 64.0 < self.cells as f64 => CELLS,
            _ => 1,
        };
        let views = match several {
            true => (self.cells / (area as usize).max(1)).clamp(LEAST_VIEWS, MOST_VIEWS),
            false => 1,
        };
        let seen = (0..views).filter_map(bounds).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
        let Some((min, max)) = seen else { return };
        let mut coverage = Coverage::new((min, max), cells_of_pixel, self.cells.max(1 << 12));
        // A mesh of very many faces counts as the box around it.
        let most = MOST_CELLS.min(16 * self.cells);
        let around = shape.mesh().filter(|mesh| views * mesh.mesh.triangles.len() > most).map(|mesh| mesh.around);
        // Each view is a small part of what is seen.
        let straight = STRAIGHT * (views as f64).sqrt();
        let is_plane = matches!(self.eyes[0].film, Film::Plane { .. } | Film::Parallel { .. });
        let corners = CORNERS[usize::from(self.is_many || (several && !is_plane))];
        let is_closed = around.is_some() || KINDS[shape.number()].encloses();
        for view in 0..views {
            let (eye, to_world) = (eye(view), pose(view));
            let at = eye.sees(&to_world);
            let mut add = |face: &[DVec3]| {
                let is_front = matches!(face, [a, b, c, ..] if (*b - *a).cross(*c - *a).dot(*a) < 0.0);
                if is_front || (lamp.two_sided && !is_closed) {
                    eye.polygons(face, straight, &mut |seen| coverage.add(seen, is_front, 1.0 / views as f64));
                }
            };
            match around {
                Some(around) => Cuboid { min: around.min, max: around.max }.faces(&at, corners, &mut add),
                None => shape.faces(&at, corners, &mut add),
            }
        }
        for (middle, share) in coverage.cells() {
            self.spread(
                middle,
                share,
                coverage.stride,
                if cells_of_pixel == CELLS { self.filter } else { Filter::Box },
                lamp.radiance,
                number,
            );
        }
    }

    /// Adds a cell that a lamp covers by a share of a pixel, to the pixels whose filter reaches it. Each of their samples has the density
    /// |f| / ∫|f| of the filter f, and the weight ±∫|f|.
    fn spread(&mut self, middle: DVec2, share: f64, stride: usize, filter: Filter, radiance: DVec3, lamp: u32) {
        let (column, row) = (middle.x.floor() as i64, middle.y.floor() as i64);
        let reach = if filter == Filter::Box { 0 } else { REACH as i64 };
        let of_weight = if filter == Filter::Mitchell { ABSOLUTE_MITCHELL } else { 1.0 };
        for y in (row - reach).max(0)..(row + reach + 1).min(i64::from(self.size.1)) {
            for x in (column - reach).max(0)..(column + reach + 1).min(i64::from(self.size.0)) {
                let weight = filter_value(filter, middle - DVec2::new(x as f64 + 0.5, y as f64 + 0.5));
                if weight == 0.0 {
                    continue;
                }
                let pixel = y as u32 * self.size.0 + x as u32;
                let into = self.pixels.entry((pixel, stride)).or_insert(LampPixel {
                    pixel,
                    count: stride as f32,
                    ..LampPixel::default()
                });
                let share = share * weight.abs();
                let brightest = |square: Rgb<f32>| square.into_iter().fold(0.0, f32::max);
                let square = radiance.to_array().map(|l| (share * of_weight * l * l) as f32);
                if brightest(square) > brightest(into.square) {
                    into.lamp = lamp;
                }
                into.share += (share / of_weight) as f32;
                for c in 0..3 {
                    into.mean[c] += (share * weight.signum() * radiance[c]) as f32;
                    into.square[c] += square[c];
                }
            }
        }
    }
}

/// ∫|f| of the filter of Mitchell and Netravali (shaders/filter/mitchell).
const ABSOLUTE_MITCHELL: f64 = 1.069_970_845_481_049_5 * 1.069_970_845_481_049_5;

/// A filter at an offset from the pixel's middle, in pixels (shaders/filter). Its integral is 1.
fn filter_value(filter: Filter, DVec2 { x, y }: DVec2) -> f64 {
    let mitchell = |x: f64| match (x, 2.0 - x) {
        _ if x < 1.0 => 8.0 / 9.0 + x * x * (x * (7.0 / 6.0) - 2.0),
        (_, y) if y > 0.0 => y * y * (y * (7.0 / 18.0) - 1.0 / 3.0),
        _ => 0.0,
    };
    match filter {
        Filter::Box => 1.0,
        Filter::Tent => (1.0 - x.abs()).max(0.0) * (1.0 - y.abs()).max(0.0),
        Filter::Gauss if x * x + y * y < 2.25 => {
            (-2.0 * (x * x + y * y)).exp() * (2.0 / (PI * 0.988_891_003_461_775_7))
        }
        Filter::Gauss => 0.0,
        Filter::Mitchell => mitchell(x.abs()) * mitchell(y.abs()),
    }
}

/// The transform of an object that moves, at a time from 0 to 1.
fn at_time(to_world: &Similarity, motion: &[MotionStep], time: f64) -> Similarity {
    if motion.is_empty() {
        return *to_world;
    }
    let moved = |p: DVec3| motion.iter().fold(p, |p, step| step.point_at(p, time));
    let translation = moved(to_world.translation);
    let axis = |axis: DVec3| moved(to_world.translation + to_world.scale * axis) - translation;
    let DMat3 { x_axis, y_axis, z_axis } = to_world.rotation;
    let axes = [x_axis, y_axis, z_axis].map(axis);
    let scale = axes[0].length();
    let rotation = DMat3::from_cols(axes[0] / scale, axes[1] / scale, axes[2] / scale);
    Similarity { scale, rotation, translation }
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::time::{Duration, Instant};

    use glam::DMat2;

    use super::*;
    use crate::flatten::flatten;
    use crate::options::RenderOptions;

    /// The pixels of 32 x 18 that these lamps cover. A camera at the origin looks along -z; a pixel is 1/18 wide at distance 1.
    fn seen(camera: &str, filter: Filter, objects: &str) -> Vec<LampPixel> {
        let text = format!(
            "Scene(image: (width: 32, height: 18),
            camera: (look_from: (0, 0, 0), look_at: (0, 0, -1), vertical_fov: 53.13010235415598{camera}),
            background: Solid((0, 0, 0)),
            materials: {{ \"lamp\": DiffuseLight(emit: Rgb(8, 4, 2)), \"down\": DiffuseLight(emit: Rgb(8, 4, 2), two_sided: false),
                \"ghost\": Lambertian(albedo: Rgb(0, 0, 0), emission: Rgb(8, 4, 2), alpha: Rgb(0, 0, 0)) }},
            objects: [{objects}])"
        );
        let scene = Scene::parse(&text, Path::new("test.ron")).unwrap();
        flatten(&scene, (32, 18), &RenderOptions { filter, ..RenderOptions::default() }).unwrap().lamps
    }

    /// The area of the lamps in pixels, those without noise left out.
    fn area(pixels: &[LampPixel]) -> f64 {
        pixels.iter().map(|pixel| f64::from(pixel.count * pixel.mean[0])).sum::<f64>()
    }

    const SMALL: f64 = 0.4 / 18.0;

    fn near(found: f64, expected: f64, share: f64) {
        assert!((found / expected - 1.0).abs() < share, "{found} {expected}");
    }

    /// The direction of a point of a film: the one that it shows there, by Gauss and Newton's steps. They start along the axis.
    fn direction_of(film: &Film, at: DVec2) -> Option<DVec3> {
        let mut direction = DVec3::Z;
        if matches!(film, Film::Parallel { .. }) {
            return Some(direction);
        }
        for _ in 0..40 {
            let (u, v) = direction.any_orthonormal_pair();
            let rest = film.shortest(at - film.point(direction)?);
            let slope = |axis: DVec3| Some((film.point(direction + 1e-6 * axis)? - film.point(direction)?) * 1e6);
            let step = DMat2::from_cols(slope(u)?, slope(v)?).inverse() * rest;
            let step = step * (0.3 / step.length()).min(1.0);
            direction = (direction + step.x * u + step.y * v).normalize();
            if step.length() < 1e-9 {
                break;
            }
        }
        (film.point(direction)?.distance(at) < 1e-6).then_some(direction)
    }

    /// On films that bend lines, a lamp covers the pixels whose rays meet it: before the camera, beside it, and behind it, where a panorama has its
    /// seam.
    #[test]
    fn lamps_cover_what_rays_of_bent_films_meet() {
        for (projection, lamps) in [
            ("Orthographic(height: 3)", 2),
            ("Equirectangular()", 5),
            ("Equirectangular(horizontal: (-100, 60), vertical: (-30, 90))", 3),
            ("Fisheye(model: Equidistant, fov: 160)", 3),
            ("Fisheye(model: Stereographic, fov: 200)", 4),
            ("Calibrated(fx: 18, fy: 15, cx: 17, cy: 8, distortion: Brown(k1: -0.2, p2: 0.01))", 2),
            ("Calibrated(fx: 9, fy: 9, cx: 16, cy: 9, distortion: KannalaBrandt(k1: -0.02))", 3),
        ] {
            let text = |objects: &str| {
                format!(
                    "Scene(image: (width: 32, height: 18), camera: (look_from: (0, 0, 0), look_at: (0, 0, -1), projection: {projection}),
                    background: Solid((0, 0, 0)), materials: {{ \"lamp\": DiffuseLight(emit: Rgb(8, 4, 2)) }}, objects: [{objects}])"
                )
            };
            const RAYS: usize = 16;
            let scene = Scene::parse(&text(""), Path::new("test.ron")).unwrap();
            let film = Film::new(&scene.camera, (32, 18), scene.image);
            let ray = |i: usize, pixel: usize| {
                let corner = DVec2::new((pixel % 32) as f64, (pixel / 32) as f64) - DVec2::new(16.0, 9.0);
                let at = corner + (DVec2::new((i % RAYS) as f64, (i / RAYS) as f64) + 0.5) / RAYS as f64;
                let origin = match film {
                    Film::Parallel { pixel } => (pixel * at).extend(0.0),
                    _ => DVec3::ZERO,
                };
                Some((origin, direction_of(&film, at)?))
            };
            let pixels: Vec<Vec<_>> =
                (0..32 * 18).map(|pixel| (0..RAYS * RAYS).map(|i| ray(i, pixel)).collect()).collect();
            let mut seen = 0;
            for (x, y, z) in [(0.4, 0.2, -3.0), (-0.9, -0.1, -4.0), (3.0, 0.5, 0.2), (-0.5, 2.5, 0.1), (0.1, 0.3, 3.0)]
            {
                let object = format!("Sphere(center: ({x}, {y}, {z}), radius: 0.4, material: \"lamp\")");
                let scene = Scene::parse(&text(&object), Path::new("test.ron")).unwrap();
                let found = flatten(&scene, (32, 18), &RenderOptions::default()).unwrap().lamps;
                let center = DVec3::new(x, -y, -z);
                let meets = |(origin, direction): &(DVec3, DVec3)| {
                    let to = center - *origin;
                    to.dot(*direction) > 0.0 && to.reject_from_normalized(*direction).length() < 0.4
                };
                let mut area = 0.0;
                for (pixel, rays) in (0..).zip(&pixels) {
                    let share = rays.iter().flatten().filter(|ray| meets(ray)).count() as f64 / (RAYS * RAYS) as f64;
                    area += share;
                    let own =
                        found.iter().filter(|own| own.pixel == pixel).map(|own| f64::from(own.share)).sum::<f64>();
                    // Pixels that are all lamp have no noise, and are left out.
                    let own = if own == 0.0 && share > 0.99 { share } else { own };
                    // The edges of triangles are straight to 0.02 pixels.
                    assert!((own - share).abs() < 0.1, "{projection} {object}: pixel {pixel} {own} {share}");
                }
                seen += u32::from(area > 0.0);
            }
            assert_eq!(seen, lamps, "{projection}");
        }
    }

    /// Each shape has its area on the film: in pixels a² for a cube's front of 10 a at distance 10. The radiance is in units of 8, as that is the
    /// largest, and a power of two.
    #[test]
    fn shapes_cover_their_area() {
        let a = 10.0 * SMALL;
        let half = 0.5 * a;
        let square = 0.4f64 * 0.4;
        let unit = 0.5;
        let quad = format!("Quad(corner: (-{half}, -{half}, -10), u: ({a}, 0, 0), v: (0, {a}, 0), material: \"lamp\")");
        let ball = format!("Sphere(center: (0.3, 0.2, -10), radius: {half}, material: \"lamp\")");
        let disk = format!("Disk(center: (0.3, 0.2, -10), normal: (0, 0, 1), radius: {half}, material: \"down\")");
        let cube = format!("Box(min: (-{half}, -{half}, -10.001), max: ({half}, {half}, -10), material: \"lamp\")");
        for (object, expected) in [(&quad, 1.0), (&ball, 0.25 * PI), (&disk, 0.25 * PI), (&cube, 1.0)] {
            let pixels = seen("", Filter::Box, object);
            near(area(&pixels), unit * square * expected, 0.01);
            for pixel in &pixels {
                let [r, g, b] = pixel.mean;
                assert_eq!((g, b, pixel.count), (0.5 * r, 0.25 * r, 1.0));
                near(f64::from(pixel.mean[0]), unit * f64::from(pixel.share), 1e-5);
                near(f64::from(pixel.square[0]), unit * unit * f64::from(pixel.share), 1e-5);
            }
            // A filter moves light to other pixels; it is evaluated in the middles of cells of a quarter of a pixel. The weights of Mitchell and Netravali's have either sign.
            for filter in [Filter::Tent, Filter::Gauss, Filter::Mitchell] {
                let pixels = seen("", filter, object);
                near(area(&pixels), unit * square * expected, 0.05);
                assert_eq!(pixels.iter().any(|pixel| pixel.mean[0] < 0.0), filter == Filter::Mitchell);
                let share: f64 = pixels.iter().map(|pixel| f64::from(pixel.share)).sum();
                // How the absolute values of Mitchell and Netravali's add up depends on the place.
                near(share, square * expected, if filter == Filter::Mitchell { 0.15 } else { 0.05 });
            }
            // In motion and out of focus too. The camera moves along with nothing.
            let moving = format!(
                "Moving(keys: [(0, [Translate((-2, 0, 0))]), (1, [Translate((2, 0.5, 0))])], object: {object})"
            );
            let pixels = seen(", shutter: (0, 1)", Filter::Box, &moving);
            near(area(&pixels), unit * square * expected, 0.03);
            assert!(pixels.len() > 7 && pixels.iter().all(|pixel| pixel.share < 0.15), "{pixels:?}");
            let pixels = seen(", aperture: 0.5, focus_distance: 2", Filter::Box, object);
            near(area(&pixels), unit * square * expected, 0.05);
            assert!(pixels.len() > 9);
        }
    }

    /// A lamp that the camera cannot see has no edges in the image, nor one that covers all of it or that no alpha shows.
    #[test]
    fn lamps_without_edges_in_the_image_cover_no_pixel_in_part() {
        for object in [
            "Sphere(center: (0, 0, 10), radius: 1, material: \"lamp\")",
            "Sphere(center: (0, 0, 0.1), radius: 1, material: \"lamp\")",
            "Sphere(center: (40, 0, -10), radius: 1, material: \"lamp\")",
            "Sphere(center: (0, 0, -2000002), radius: 2000000, material: \"lamp\")",
            "Quad(corner: (-1, 1, -1), u: (2, 0, 0), v: (0, 0, -2), material: \"lamp\"), Box(min: (-1, -1, -1), max: (1, 1, 1), material: \"lamp\")",
            "Quad(corner: (-1000, -1000, -1), u: (2000, 0, 0), v: (0, 2000, 0), material: \"lamp\")",
            "Quad(corner: (-1, -1, -1), u: (0, 2, 0), v: (2, 0, 0), material: \"down\")",
            "Quad(corner: (-0.1, -0.1, -1), u: (0.23, 0, 0), v: (0, 0.23, 0), material: \"ghost\")",
        ] {
            let found = seen("", Filter::Box, object);
            let is_ceiling = object.contains("Box");
            assert!(found.is_empty() || is_ceiling, "{object}: {found:?}");
        }
    }

    /// A quad that reaches behind the camera is cut; a lamp at a great distance is as exact as a near one.
    #[test]
    fn lamps_around_the_camera_and_far_ones_are_projected() {
        let road = "Quad(corner: (-1, -1, 5), u: (2, 0, 0), v: (0, 0, -50), material: \"lamp\")";
        let found = seen("", Filter::Box, road);
        assert!(found.len() > 16 && found.iter().all(|pixel| pixel.pixel / 32 >= 9), "{}", found.len());
        let far = format!("Sphere(center: (3e5, 2e5, -1e6), radius: {}, material: \"lamp\")", 1e6 * 0.5 * SMALL);
        near(area(&seen("", Filter::Box, &far)), 0.5 * 0.16 * 0.25 * PI, 0.1);
    }

    /// Very many lamps take a bounded time; lamps behind each other cover a pixel once.
    #[test]
    fn very_many_lamps_are_projected_in_seconds() {
        let number = |i: usize, step: f64| (0.5 + step * i as f64).fract() - 0.5;
        let ball = |i: usize| {
            let (x, y) = (18.0 * number(i, 0.618_033_988), 10.0 * number(i, 0.414_213_562));
            format!("Sphere(center: ({x}, {y}, -10), radius: 0.02, material: \"lamp\"),")
        };
        let many: String = (0..20_000).map(ball).collect();
        let start = Instant::now();
        let found = seen(", aperture: 0.1", Filter::Mitchell, &many);
        assert!(found.iter().all(|pixel| pixel.share <= 1.0) && found.len() > 300, "{}", found.len());
        assert!(start.elapsed() < Duration::from_secs(20), "{:?}", start.elapsed());
    }
}

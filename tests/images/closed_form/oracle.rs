//! What a scene of textured things shows, by a ray tracer in f64 that shares nothing with the renderer: it transforms the ray into each object's
//! own space step by step, and looks the colour up there. For textures, transforms and cameras, whose images have closed forms
//! pixel by pixel, but long ones.

use std::fmt::Write;

use glam::DVec3;
use gpu_rt::scene::Camera;

use crate::common::expect::View;
use crate::common::render::Shot;

/// A transform, as a scene file lists them.
#[derive(Clone, Copy, Debug)]
pub enum Move {
    Scale(f64),
    Translate(DVec3),
    X(f64),
    Y(f64),
    Z(f64),
}

impl Move {
    /// Undoes the move: of a point, or of a direction, which no translation moves.
    fn undo(self, v: DVec3, is_point: bool) -> DVec3 {
        let turn = |a: f64, b: f64, degrees: f64| {
            let (s, c) = degrees.to_radians().sin_cos();
            (c * a + s * b, c * b - s * a)
        };
        match self {
            Move::Scale(factor) => v / factor,
            Move::Translate(by) if is_point => v - by,
            Move::Translate(_) => v,
            // Forwards, RotateX takes y to z, RotateY z to x and RotateZ x to y.
            Move::X(degrees) => {
                let (y, z) = turn(v.y, v.z, degrees);
                DVec3::new(v.x, y, z)
            }
            Move::Y(degrees) => {
                let (z, x) = turn(v.z, v.x, degrees);
                DVec3::new(x, v.y, z)
            }
            Move::Z(degrees) => {
                let (x, y) = turn(v.x, v.y, degrees);
                DVec3::new(x, y, v.z)
            }
        }
    }

    fn text(self) -> String {
        match self {
            Move::Scale(factor) => format!("Scale({factor})"),
            Move::Translate(by) => format!("Translate({})", vector(by)),
            Move::X(degrees) => format!("RotateX({degrees})"),
            Move::Y(degrees) => format!("RotateY({degrees})"),
            Move::Z(degrees) => format!("RotateZ({degrees})"),
        }
    }
}

#[derive(Clone, Copy, Debug)]
pub enum Shape {
    Sphere { center: DVec3, radius: f64 },
    Quad { corner: DVec3, u: DVec3, v: DVec3 },
    Box { min: DVec3, max: DVec3 },
}

/// Where a ray meets a shape, in the shape's own space.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    t: f64,
    pub point: DVec3,
    /// As the scene format defines it for images.
    pub uv: (f64, f64),
}

impl Shape {
    fn text(&self, material: &str) -> String {
        match *self {
            Shape::Sphere { center, radius } => {
                format!("Sphere(center: {}, radius: {radius}, material: \"{material}\")", vector(center))
            }
            Shape::Quad { corner, u, v } => {
                let [corner, u, v] = [corner, u, v].map(vector);
                format!("Quad(corner: {corner}, u: {u}, v: {v}, material: \"{material}\")")
            }
            Shape::Box { min, max } => {
                format!("Box(min: {}, max: {}, material: \"{material}\")", vector(min), vector(max))
            }
        }
    }

    /// The nearest hit in front of the origin.
    fn meet(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        match *self {
            Shape::Sphere { center, radius } => {
                let f = origin - center;
                let (a, b) = (direction.length_squared(), f.dot(direction));
                let root = (b * b - a * (f.length_squared() - radius * radius)).sqrt();
                // No root is not a number, which is not above zero.
                let t = [(-b - root) / a, (-b + root) / a].into_iter().find(|t| *t > 0.0)?;
                let point = origin + t * direction;
                let n = (point - center) / radius;
                let turn = std::f64::consts::TAU;
                let uv = (((-n.z).atan2(n.x) + turn / 2.0) / turn, (-n.y).acos() / (turn / 2.0));
                Some(Hit { t, point, uv })
            }
            Shape::Quad { corner, u, v } => {
                let normal = u.cross(v);
                let t = (corner - origin).dot(normal) / direction.dot(normal);
                let point = origin + t * direction;
                let area = normal.length_squared();
                let a = (point - corner).cross(v).dot(normal) / area;
                let b = u.cross(point - corner).dot(normal) / area;
                let inside = t > 0.0 && (0.0..=1.0).contains(&a) && (0.0..=1.0).contains(&b);
                inside.then_some(Hit { t, point, uv: (a, b) })
            }
            Shape::Box { min, max } => {
                let faces = (0..3).flat_map(|axis| [(axis, min[axis], false), (axis, max[axis], true)]);
                let hits = faces.filter_map(|(axis, at, high)| {
                    let t = (at - origin[axis]) / direction[axis];
                    let point = origin + t * direction;
                    let others = [(axis + 1) % 3, (axis + 2) % 3];
                    let inside = others.iter().all(|&o| (min[o]..=max[o]).contains(&point[o]));
                    let p = (point - min) / (max - min);
                    // Seen from outside, u to the right and v up; from above and below, u along x.
                    let uv = match (axis, high) {
                        (0, true) => (1.0 - p.z, p.y),
                        (0, false) => (p.z, p.y),
                        (1, true) => (p.x, 1.0 - p.z),
                        (1, false) => (p.x, p.z),
                        (_, true) => (p.x, p.y),
                        (_, false) => (1.0 - p.x, p.y),
                    };
                    (t > 0.0 && inside).then_some(Hit { t, point, uv })
                });
                hits.min_by(|a, b| a.t.total_cmp(&b.t))
            }
        }
    }
}

/// The value of a texture at a point; `None` where rounding or filtering decides.
pub type Colour = Box<dyn Fn(&Hit) -> Option<[f64; 3]>>;

/// A textured thing, somewhere.
pub struct Thing {
    pub shape: Shape,
    pub moves: Vec<Move>,
    /// The texture as the scene file writes it, and what it means.
    pub texture: String,
    pub colour: Colour,
}

/// What the textures are of. Either shows its colour without noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    Lamps,
    /// One convex Lambertian body, under the sky Solid((1, 1, 1)).
    Body,
}

/// Things before a sky.
pub struct Things {
    pub kind: Kind,
    pub size: (u32, u32),
    /// As the scene file writes them.
    pub camera: String,
    pub background: String,
    pub things: Vec<Thing>,
    /// The sky's colour by direction.
    pub sky: Box<dyn Fn(DVec3) -> Option<[f64; 3]>>,
}

fn vector(v: DVec3) -> String {
    format!("({:?}, {:?}, {:?})", v.x, v.y, v.z)
}

impl Things {
    /// The scene file.
    pub fn text(&self) -> String {
        let (mut materials, mut objects) = (String::new(), String::new());
        for (i, thing) in self.things.iter().enumerate() {
            let name = format!("thing {i}");
            let model = match self.kind {
                Kind::Lamps => "DiffuseLight(emit",
                Kind::Body => "Lambertian(albedo",
            };
            let _ = writeln!(materials, "\"{name}\": {model}: {}),", thing.texture);
            // One transform inside another: the list's first half is the inner one.
            let moves: Vec<_> = thing.moves.iter().map(|m| m.text()).collect();
            let (inner, outer) = moves.split_at(moves.len() / 2);
            let (inner, outer) = (inner.join(", "), outer.join(", "));
            let shape = thing.shape.text(&name);
            let _ = writeln!(
                objects,
                "Transformed(by: [{outer}], object: Group([Transformed(by: [{inner}], object: {shape})])),"
            );
        }
        format!(
            "Scene(image: (width: {}, height: {}), camera: ({}), background: {}, materials: {{ {materials} }}, \
             objects: [{objects}], render: (samples: 16))",
            self.size.0, self.size.1, self.camera, self.background
        )
    }

    /// What a camera ray brings.
    fn trace(&self, origin: DVec3, direction: DVec3) -> Option<[f64; 3]> {
        let hits = self.things.iter().filter_map(|thing| {
            let undo = |v, is_point| thing.moves.iter().rev().fold(v, |v, m| m.undo(v, is_point));
            // The direction keeps its scale, so that t is the same in every space.
            let hit = thing.shape.meet(undo(origin, true), undo(direction, false))?;
            Some((hit, &thing.colour))
        });
        let nearest = hits.min_by(|a, b| a.0.t.total_cmp(&b.0.t));
        match nearest {
            Some((hit, colour)) => colour(&hit),
            None => (self.sky)(direction),
        }
    }

    /// Compares an image with what these things show, in the pixels that show one colour; the rest, on the edges, is left out.
    /// Fails also where too little can be compared: `colours` is how many colours must be found, in ten pixels each at least.
    pub fn check(&self, shot: &Shot, camera: &Camera, colours: usize) -> Result<(), String> {
        /// Rays into a pixel along each axis: nothing in these scenes is finer.
        const PROBES: i32 = 8;
        /// How far the rays go over the pixel's edge, so that nothing slips in between.
        const MARGIN: f64 = 0.25;
        /// Samples of one colour are added without noise: see ROUNDING in expect.rs.
        const TOLERANCE: f64 = 1e-6;
        let view = View::new(camera, self.size);
        let mut seen: Vec<([f64; 3], u32)> = Vec::new();
        for y in 0..self.size.1 {
            for x in 0..self.size.0 {
                let offset = |i: i32| -MARGIN + (1.0 + 2.0 * MARGIN) * f64::from(i) / f64::from(PROBES);
                let hits = (0..=PROBES).flat_map(|i| (0..=PROBES).map(move |j| (offset(i), offset(j))));
                let mut colours =
                    hits.map(|(u, v)| self.trace(camera.look_from, view.direction(f64::from(x) + u, f64::from(y) + v)));
                let Some(expected) = colours.next().flatten() else { continue };
                if !colours.all(|colour| colour == Some(expected)) {
                    continue;
                }
                let found = shot.pixel(x, y);
                if (0..3).any(|c| (found[c] - expected[c]).abs() > TOLERANCE * expected[c]) {
                    return Err(format!("pixel ({x}, {y}) is {found:?}, expected {expected:?}"));
                }
                match seen.iter_mut().find(|(colour, _)| *colour == expected) {
                    Some((_, count)) => *count += 1,
                    None => seen.push((expected, 1)),
                }
            }
        }
        let enough = seen.iter().filter(|(_, count)| *count >= 10).count();
        match enough >= colours {
            true => Ok(()),
            false => Err(format!("{colours} colours are to be compared, and these are there: {seen:?}")),
        }
    }
}

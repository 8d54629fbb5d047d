//! Cuts flat lights whose radiance varies into parts, each of which is a light of the tree.
//!
//! A light that is sampled uniformly in its area, with the mean radiance of each part as the probability of the part, has the second moment
//! `P Σ a q² / m` (own derivation): the sum is over the parts, with `a` the area of a part, `m` its mean luminance and `q²` that of
//! its squares; `P` is the sum of `a m`. It is at least `P²`, which leaves no variance. So the part with the largest excess
//! `a (q² / m - m)` is cut first.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use crate::luminance::{Area, Luminance};
use crate::shape::{Aabb, ObjectTransform, Shape};

/// The most parts of a shape.
const MOST_PARTS: usize = 64;
/// The most parts of all shapes, to bound the time.
const MOST_PARTS_OF_SCENE: usize = 1 << 15;
/// The excess of all parts, as a share of their power, up to which a light is even.
const EVEN: f64 = 0.05;
/// The largest exponent of a part's column or row (shaders/light/parts).
const FINEST: u32 = 11;

/// A part of a light, by the cell of a grid over the shape's coordinates (shaders/light/parts).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LightPart {
    /// The numbers of columns and rows are two to the power of these.
    exponents: [u32; 2],
    cell: [u32; 2],
    /// True of the half of a triangle's cell above the diagonal.
    is_above: bool,
}

impl LightPart {
    pub fn code(self) -> u32 {
        let [[i, j], [x, y]] = [self.cell, self.exponents];
        i | j << 11 | x << 22 | y << 26 | u32::from(self.is_above) << 30
    }

    fn size(self) -> DVec2 {
        DVec2::from_array(self.exponents.map(|exponent| 0.5f64.powi(exponent as i32)))
    }

    fn low(self) -> DVec2 {
        DVec2::from_array(self.cell.map(f64::from)) * self.size()
    }

    /// The share of the shape's area that the part has.
    pub fn share(self) -> f64 {
        self.size().element_product()
    }

    /// Two halves along an axis.
    fn halves(self, axis: usize) -> [LightPart; 2] {
        [0, 1].map(|side| {
            let mut half = self;
            half.exponents[axis] += 1;
            half.cell[axis] = 2 * half.cell[axis] + side;
            half
        })
    }

    /// The four triangles of half its size that it consists of.
    fn quarters(self) -> [LightPart; 4] {
        let above = u32::from(self.is_above);
        [([0, 0], false), ([1, 0], false), ([0, 1], false), ([0, 0], true)].map(|([i, j], is_above)| {
            // A triangle above the diagonal has the same four, turned by half a turn.
            let turned = |bit: u32| if self.is_above { 1 - bit } else { bit };
            LightPart {
                exponents: self.exponents.map(|exponent| exponent + 1),
                cell: [2 * self.cell[0] + turned(i), 2 * self.cell[1] + turned(j)],
                is_above: is_above != (above == 1),
            }
        })
    }
}

/// The coordinates of a shape.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Coordinates {
    /// Shares of two edges.
    Quad,
    /// Shares of two edges, below the diagonal.
    Triangle,
    /// The square of the radius, and the turns from the direction opposite to the first edge of the square around the disk.
    Disk,
}

/// A flat shape: a corner with two edges, in the object's own space and in texture coordinates.
pub struct Outline {
    coordinates: Coordinates,
    corner: DVec3,
    edges: [DVec3; 2],
    uv: DVec2,
    uv_edges: [DVec2; 2],
}

impl Outline {
    /// The outline of a flat shape; of a mesh, that of this face, with this set of texture coordinates.
    pub fn new(shape: &Shape<'_>, face: usize, uv_set: u32) -> Option<Outline> {
        let of_square = |coordinates, corner, u, v| {
            Some(Outline { coordinates, corner, edges: [u, v], uv: DVec2::ZERO, uv_edges: [DVec2::X, DVec2::Y] })
        };
        match shape {
            Shape::Quad(quad) => of_square(Coordinates::Quad, quad.corner, quad.u, quad.v),
            Shape::Disk(disk) => {
                let square = disk.square();
                of_square(Coordinates::Disk, square.corner, square.u, square.v)
            }
            Shape::Mesh(shape) => {
                let corners = *shape.mesh.triangles.get(face)?;
                let [a, b, c] = corners.map(|corner| shape.mesh.positions[corner as usize]);
                let uvs = shape.mesh.uvs_of(uv_set);
                let [p, q, r] = corners.map(|corner| uvs.get(corner as usize).copied().unwrap_or_default().as_dvec2());
                Some(Outline {
                    coordinates: Coordinates::Triangle,
                    corner: a,
                    edges: [b - a, c - a],
                    uv: p,
                    uv_edges: [q - p, r - p],
                })
            }
            _ => None,
        }
    }

    /// Points around a part, as shares of the two edges.
    fn points(&self, part: LightPart) -> [DVec2; 4] {
        let (low, size) = (part.low(), part.size());
        let high = low + size;
        match self.coordinates {
            Coordinates::Quad => [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)],
            Coordinates::Triangle => {
                let (first, step) = if part.is_above { (high, -size) } else { (low, size) };
                [first, first + step.with_y(0.0), first + step.with_x(0.0), first]
            }
            Coordinates::Disk => {
                // The corners of a box around the piece of a ring, which bulges over the chord between its own.
                let at = |x: f64, y: f64| x.sqrt() * DVec2::from_angle(TAU * (y - 0.5));
                let corners = [at(low.x, low.y), at(high.x, low.y), at(low.x, high.y), at(high.x, high.y)];
                let bulge = high.x.sqrt() * (1.0 - (0.5 * TAU * size.y).min(0.5 * TAU).cos());
                let least = corners.into_iter().fold(DVec2::INFINITY, DVec2::min) - bulge;
                let most = corners.into_iter().fold(DVec2::NEG_INFINITY, DVec2::max) + bulge;
                let (low, high) = (least.max(DVec2::NEG_ONE), most.min(DVec2::ONE));
                [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)].map(|point| 0.5 + 0.5 * point)
            }
        }
    }

    fn point(&self, at: DVec2) -> DVec3 {
        self.corner + at.x * self.edges[0] + at.y * self.edges[1]
    }

    /// The box around a part in render space.
    pub fn bounds(&self, part: LightPart, to_render: &ObjectTransform<'_>) -> Aabb {
        Aabb::around(self.points(part).map(|at| to_render.point(self.point(at))))
    }

    fn area(&self, part: LightPart) -> Area {
        let points = self.points(part);
        let uvs = points.map(|at| self.uv + at.x * self.uv_edges[0] + at.y * self.uv_edges[1]);
        let middle = match self.coordinates {
            Coordinates::Triangle => (points[0] + points[1] + points[2]) / 3.0,
            Coordinates::Quad | Coordinates::Disk => 0.5 * (points[0] + points[2]),
        };
        Area {
            low: uvs.into_iter().fold(DVec2::INFINITY, DVec2::min),
            high: uvs.into_iter().fold(DVec2::NEG_INFINITY, DVec2::max),
            middle: self.point(middle),
        }
    }

    /// The mean luminance of each of 4^depth cells of a part: of a triangle in any order, else row by row.
    fn cells(&self, part: LightPart, luminance: &Luminance<'_>, depth: u32) -> Vec<f64> {
        let within: Vec<LightPart> = match self.coordinates {
            Coordinates::Triangle => {
                let quarters = |parts: Vec<LightPart>, _| parts.into_iter().flat_map(LightPart::quarters).collect();
                (0..depth).fold(vec![part], quarters)
            }
            Coordinates::Quad | Coordinates::Disk => {
                let cell = |number: u32| LightPart {
                    exponents: part.exponents.map(|exponent| exponent + depth),
                    cell: [
                        (part.cell[0] << depth) | (number % (1 << depth)),
                        (part.cell[1] << depth) | (number >> depth),
                    ],
                    is_above: false,
                };
                (0..1 << (2 * depth)).map(cell).collect()
            }
        };
        within.into_iter().map(|cell| luminance.mean(&self.area(cell))).collect()
    }

    fn power(&self, part: LightPart, luminance: &Luminance<'_>, depth: u32) -> Power {
        let cells = self.cells(part, luminance, depth);
        let mean = |sum: f64| sum / cells.len() as f64;
        Power { mean: mean(cells.iter().sum()), of_squares: mean(cells.iter().map(|cell| cell * cell).sum()) }
    }

    /// The parts into which one is cut: across the axis along which it varies more, or else across the longer side.
    fn cut(&self, part: LightPart, luminance: &Luminance<'_>, depth: u32) -> Vec<LightPart> {
        if self.coordinates == Coordinates::Triangle {
            return part.quarters().to_vec();
        }
        let (cells, side) = (self.cells(part, luminance, depth), 1 << depth);
        let (mut columns, mut rows) = (vec![0.0; side], vec![0.0; side]);
        for (number, cell) in cells.into_iter().enumerate() {
            columns[number % side] += cell;
            rows[number / side] += cell;
        }
        let variation = [columns, rows].map(|sums| sums.iter().map(|sum| sum * sum).sum::<f64>());
        let size = part.size();
        let lengths = [size.x * self.edges[0].length(), size.y * self.edges[1].length()];
        let order = variation[1].total_cmp(&variation[0]).then(lengths[1].total_cmp(&lengths[0]));
        let can_be_cut = part.exponents.map(|exponent| exponent < FINEST);
        let axis = usize::from(!can_be_cut[0] || can_be_cut[1] && order.is_gt());
        part.halves(axis).to_vec()
    }

    /// Parts of like radiance, at most this many, with the mean luminance of each.
    pub fn parts(&self, luminance: &Luminance<'_>, depth: u32, most: usize) -> Vec<(LightPart, f64)> {
        let added = if self.coordinates == Coordinates::Triangle { 3 } else { 1 };
        let look = |part| (part, self.power(part, luminance, depth));
        let mut parts = vec![look(LightPart::default())];
        while parts.len() + added <= most.min(MOST_PARTS) {
            let excess = |(part, power): &(LightPart, Power)| part.share() * (power.moment() - power.mean);
            let all: f64 = parts.iter().map(excess).sum();
            let power: f64 = parts.iter().map(|(part, power)| part.share() * power.mean).sum();
            let can_be_cut = |part: &LightPart| part.exponents.iter().any(|exponent| *exponent < FINEST);
            let numbers = (0..parts.len()).filter(|i| can_be_cut(&parts[*i].0));
            let worst = numbers.max_by(|a, b| excess(&parts[*a]).total_cmp(&excess(&parts[*b])));
            match worst {
                Some(worst) if all > EVEN * power => {
                    let within = self.cut(parts[worst].0, luminance, depth);
                    parts.splice(worst..=worst, within.into_iter().map(look));
                }
                _ => break,
            }
        }
        parts.into_iter().map(|(part, power)| (part, power.mean)).collect()
    }

    /// The mean luminance, and whether it varies.
    pub fn mean(&self, luminance: &Luminance<'_>, depth: u32) -> (f64, bool) {
        let power = self.power(LightPart::default(), luminance, depth);
        (power.mean, power.moment() - power.mean > EVEN * power.mean)
    }
}

/// The luminance of a part.
#[derive(Clone, Copy)]
struct Power {
    mean: f64,
    /// The mean of squares.
    of_squares: f64,
}

impl Power {
    /// The second moment per area, over the power of the shape.
    fn moment(&self) -> f64 {
        if self.mean > 0.0 { self.of_squares / self.mean } else { 0.0 }
    }
}

/// The depth to which each of so many shapes is looked at.
pub fn depth_for(shapes: usize) -> u32 {
    match shapes {
        0..=0x4000 => 3,
        0x4001..=0x20000 => 2,
        _ => 1,
    }
}

/// The most parts of each of so many shapes that vary, with so much room for more lights.
pub fn most_parts(varying: usize, room: usize) -> usize {
    1 + room.min(MOST_PARTS_OF_SCENE) / varying.max(1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bitmap::{Bitmap, Bitmaps, Decoding};
    use crate::shape::Quad;
    use crate::texture::{Colour, Texture, Wrap};

    fn hot(width: u32, height: u32, hot: (u32, u32)) -> (Texture, Bitmaps) {
        let mut bitmaps = Bitmaps::default();
        let at = (hot.1 * width + hot.0) as usize;
        let texels = (0..(width * height) as usize).map(|i| [if i == at { 700.0 } else { 0.02 }; 3]);
        bitmaps.insert("hot", Decoding::Colour, Bitmap::of_floats(width, height, texels));
        (
            Texture::Image { path: "hot".to_string(), tint: Colour::ONE, channel: None, uv_set: 0, wrap: Wrap::Repeat },
            bitmaps,
        )
    }

    fn outlines() -> [Outline; 3] {
        let quad = Outline::new(&Shape::Quad(Quad { corner: DVec3::ZERO, u: DVec3::X, v: DVec3::Y }), 0, 0);
        let quad = quad.expect("it is flat");
        let of = |coordinates| Outline { coordinates, ..quad };
        [of(Coordinates::Quad), of(Coordinates::Triangle), of(Coordinates::Disk)]
    }

    /// Whether a part has a point, as in shaders/light/parts.
    fn holds(part: LightPart, at: DVec2, is_triangle: bool) -> bool {
        let within = (at - part.low()) / part.size();
        let is_above = is_triangle && within.x + within.y > 1.0;
        within.cmpge(DVec2::ZERO).all() && within.cmplt(DVec2::ONE).all() && is_above == part.is_above
    }

    /// Each point is in one part, the parts of one texel have its light, and what does not vary is not cut.
    #[test]
    fn parts_tile_the_shape_and_isolate_a_hot_texel() {
        let even = Bitmap::of_floats(8, 8, [[3.0; 3]; 64]);
        let even = Luminance::Image(crate::luminance::SummedArea::new(&even, Colour::ONE, false).expect("texels"));
        // Of a triangle, the texel is below the diagonal.
        let (texture, bitmaps) = hot(64, 64, (20, 45));
        let luminance = Luminance::new(&texture, &bitmaps, false).expect("it varies");
        for outline in outlines() {
            let is_triangle = outline.coordinates == Coordinates::Triangle;
            assert_eq!(outline.parts(&even, 3, 64).len(), 1);
            let parts = outline.parts(&luminance, 3, 64);
            assert!(parts.len() > 16 && parts.len() <= 64, "{} parts", parts.len());
            let shares: f64 = parts.iter().map(|(part, _)| part.share()).sum();
            assert!((shares - 1.0).abs() < 1e-12, "{shares}");
            for number in 0..4096 {
                let at = DVec2::new(f64::from(number % 64) + 0.37, f64::from(number / 64) + 0.41) / 64.0;
                let holding = parts.iter().filter(|(part, _)| holds(*part, at, is_triangle)).count();
                assert_eq!(holding, usize::from(!is_triangle || at.x + at.y < 1.0), "{at}");
            }
            // Most of the power is in parts that together are a thousandth of the shape.
            let power = |bright: bool| -> f64 {
                let those = parts.iter().filter(|(_, mean)| !bright || *mean > 1.0);
                those.map(|(part, mean)| part.share() * mean).sum()
            };
            let bright: f64 = parts.iter().filter(|(_, mean)| *mean > 1.0).map(|(part, _)| part.share()).sum();
            assert!(power(true) > 0.8 * power(false) && bright < 4e-3, "{} of {}, {bright}", power(true), power(false));
            assert!(outline.parts(&luminance, 3, 4).len() <= 4);
        }
    }

    /// The box around a part has all of its points.
    #[test]
    fn boxes_are_around_parts_of_disks() {
        let [.., disk] = outlines();
        for exponents in [[0, 0], [1, 0], [0, 1], [2, 1], [1, 3], [3, 2]] {
            for cell in 0..1 << (exponents[0] + exponents[1]) {
                let cell = [cell % (1 << exponents[0]), cell >> exponents[0]];
                let part = LightPart { exponents, cell, is_above: false };
                let points = disk.points(part);
                for number in 0..81 {
                    let at = part.low() + part.size() * DVec2::new(f64::from(number % 9), f64::from(number / 9)) / 8.0;
                    let point = 0.5 + 0.5 * at.x.sqrt() * DVec2::from_angle(TAU * (at.y - 0.5));
                    let within = point.cmpge(points[0] - 1e-9).all() && point.cmple(points[2] + 1e-9).all();
                    assert!(within, "{part:?} {point} {points:?}");
                }
            }
        }
    }
}

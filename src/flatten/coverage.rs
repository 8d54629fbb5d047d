//! The area that polygons cover of the cells of a grid.

use std::ops::{Add, Mul, Sub};

use glam::DVec2;

/// The part of the film around a lamp, in cells.
pub struct Coverage {
    left: i64,
    top: i64,
    width: usize,
    /// Cells of a pixel along each axis.
    per_pixel: f64,
    /// Only one of so many rows is computed, if there are very many cells.
    pub stride: usize,
    /// By the backs of surfaces and by their fronts: a line through a closed surface meets both.
    sides: [Vec<f32>; 2],
}

impl Coverage {
    /// An empty one of these pixels, from the lowest coordinates to the highest, with `most` cells or a row of them.
    pub fn new((min, max): (DVec2, DVec2), per_pixel: u32, most: usize) -> Coverage {
        let per_pixel = f64::from(per_pixel);
        let (min, max) = ((min * per_pixel).floor(), (max * per_pixel).ceil());
        let (width, height) = ((max.x - min.x) as usize, (max.y - min.y) as usize);
        let stride = (width * height / most).max(1);
        let side = vec![0.0; width * height.div_ceil(stride)];
        Coverage { left: min.x as i64, top: min.y as i64, width, per_pixel, stride, sides: [side.clone(), side] }
    }

    /// Adds a convex polygon with a weight.
    pub fn add(&mut self, polygon: &[DVec2], is_front: bool, weight: f64) {
        let corner = DVec2::new(self.left as f64, self.top as f64);
        let corners: Vec<DVec2> = polygon.iter().map(|p| *p * self.per_pixel - corner).collect();
        let ends = |axis: usize, corners: &[DVec2], most: usize| {
            let (low, high) = corners.iter().fold((most as f64, 0.0f64), |(low, high), p| (low.min(p[axis]), high.max(p[axis])));
            low.max(0.0) as usize..(high.ceil() as usize).min(most)
        };
        let (width, side) = (self.width, &mut self.sides[usize::from(is_front)]);
        let Some(rows) = side.len().checked_div(width).map(|rows| rows * self.stride) else { return };
        for row in ends(1, &corners, rows).filter(|row| row.is_multiple_of(self.stride)) {
            let (above, below) = (row as f64, row as f64 + 1.0);
            let band = clip(&clip(&corners, |p| p.y - above), |p| below - p.y);
            let mut before = 0.0;
            for column in ends(0, &band, width) {
                let so_far = area(&clip(&band, |p| column as f64 + 1.0 - p.x));
                side[row / self.stride * width + column] += (weight * (so_far - before)) as f32;
                before = so_far;
            }
        }
    }

    /// The middle of each cell that is covered, in pixels, and the part of a pixel that is covered there.
    pub fn cells(&self) -> impl Iterator<Item = (DVec2, f64)> {
        let pairs = self.sides[0].iter().zip(&self.sides[1]).enumerate();
        pairs.filter(|(_, (back, front))| **back > 0.0 || **front > 0.0).map(|(i, (back, front))| {
            let (column, row) = (i % self.width, i / self.width * self.stride);
            let middle = DVec2::new((self.left + column as i64) as f64, (self.top + row as i64) as f64) + 0.5;
            (middle / self.per_pixel, f64::from(back.max(*front).min(1.0)) / (self.per_pixel * self.per_pixel))
        })
    }
}

/// The part of a convex polygon where a linear function is not negative (Sutherland and Hodgman, "Reentrant polygon clipping", 1974).
pub fn clip<P>(polygon: &[P], inside: impl Fn(P) -> f64) -> Vec<P>
where
    P: Copy + Add<Output = P> + Sub<Output = P> + Mul<f64, Output = P>,
{
    let mut left = Vec::with_capacity(polygon.len() + 1);
    let Some(mut before) = polygon.last().copied() else { return left };
    let mut was = inside(before);
    for &corner in polygon {
        let is = inside(corner);
        if (was < 0.0) != (is < 0.0) {
            left.push(before + (corner - before) * (was / (was - is)));
        }
        if is >= 0.0 {
            left.push(corner);
        }
        (before, was) = (corner, is);
    }
    left
}

fn area(polygon: &[DVec2]) -> f64 {
    let Some(&first) = polygon.first() else { return 0.0 };
    let pairs = polygon.windows(2);
    0.5 * pairs.map(|pair| (pair[0] - first).perp_dot(pair[1] - first)).sum::<f64>().abs()
}

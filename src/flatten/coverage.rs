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
            let (low, high) =
                corners.iter().fold((most as f64, 0.0f64), |(low, high), p| (low.min(p[axis]), high.max(p[axis])));
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

#[cfg(test)]
mod tests {
    use super::*;

    fn covered(coverage: &Coverage) -> f64 {
        coverage.cells().map(|(_, share)| share).sum::<f64>() * coverage.stride as f64
    }

    /// A turned square covers its area, and its corner an area that is known.
    #[test]
    fn cells_have_the_area_that_a_polygon_covers() {
        let diamond = [(2.5, 0.5), (4.5, 2.5), (2.5, 4.5), (0.5, 2.5)].map(|(x, y)| DVec2::new(x, y));
        for per_pixel in [1, 4] {
            let mut coverage = Coverage::new((DVec2::ZERO, DVec2::splat(5.0)), per_pixel, 1 << 12);
            coverage.add(&diamond, true, 0.5);
            assert!((covered(&coverage) - 4.0).abs() < 1e-6, "{}", covered(&coverage));
        }
        let mut coverage = Coverage::new((DVec2::ZERO, DVec2::splat(5.0)), 1, 1 << 12);
        coverage.add(&diamond, true, 1.0);
        let of = |x: f64, y: f64| coverage.cells().find(|(at, _)| *at == DVec2::new(x, y)).map(|(_, share)| share);
        // A triangle of width 1 and height 1/2, half of a pixel, all of it, and nothing.
        assert_eq!([of(2.5, 0.5), of(1.5, 1.5), of(2.5, 2.5), of(0.5, 0.5)], [Some(0.25), Some(0.5), Some(1.0), None]);
    }

    /// A line through a closed surface meets a front and a back, and sees one of them.
    #[test]
    fn both_sides_of_a_surface_cover_a_pixel_once() {
        let square = [(0.0, 0.0), (0.5, 0.0), (0.5, 0.5), (0.0, 0.5)].map(|(x, y)| DVec2::new(x, y));
        let mut coverage = Coverage::new((DVec2::ZERO, DVec2::ONE), 1, 1);
        for is_front in [true, false] {
            coverage.add(&square, is_front, 1.0);
        }
        assert_eq!(covered(&coverage), 0.25);
        coverage.add(&square, true, 9.0);
        assert_eq!(covered(&coverage), 1.0);
    }

    /// Where cells are very many, a part of the rows stands for all.
    #[test]
    fn some_rows_stand_for_all() {
        let size = DVec2::new(1000.0, 1000.0);
        let mut coverage = Coverage::new((DVec2::ZERO, size), 1, 1 << 14);
        assert_eq!((coverage.stride, coverage.sides[0].len()), (61, 17_000));
        let triangle = [DVec2::ZERO, DVec2::new(1000.0, 0.0), size];
        coverage.add(&triangle, true, 1.0);
        let area = covered(&coverage);
        assert!((area / 5e5 - 1.0).abs() < 0.1, "{area}");
        coverage.add(&[], true, 1.0);
        assert_eq!(covered(&coverage), area);
    }

    #[test]
    fn clipping_leaves_the_part_inside() {
        let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec2::new(x, y));
        assert_eq!(area(&clip(&square, |p| p.x - 0.25)), 0.75);
        assert_eq!(area(&clip(&square, |p| p.x + p.y - 1.0)), 0.5);
        assert!(clip(&square, |p| p.x - 2.0).is_empty());
        assert_eq!(clip(&square, |_| 0.0), square);
    }
}

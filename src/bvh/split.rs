//! Splits groups of primitives by the surface area heuristic, with cuts between bins (Wald 2007, "On fast
//! construction of SAH-based bounding volume hierarchies").

use glam::Vec3A;

use super::bounds::Bounds;

/// The trade-off between the time of the build and the time of the walks. It does not change the image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Quality {
    #[default]
    Medium,
    Best,
}

/// A primitive during the build. The code comes first, because vector loads of `max` also read the word after it: a code, read as a
/// float, is subnormal, which makes every operation on it slow.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Item {
    pub code: u32,
    min: [f32; 3],
    max: [f32; 3],
    zero: u32,
}

impl Item {
    pub fn new(bounds: &Bounds, code: u32) -> Item {
        Item { code, min: bounds.min.to_array(), max: bounds.max.to_array(), zero: 0 }
    }

    /// The middle of its box. It is a sum of halves, because the sum of the corners could overflow.
    fn middle(&self) -> Vec3A {
        0.5 * Vec3A::from_array(self.min) + 0.5 * Vec3A::from_array(self.max)
    }
}

/// A bounding box under construction.
#[derive(Clone, Copy)]
pub struct Extent {
    min: Vec3A,
    max: Vec3A,
}

impl Extent {
    const EMPTY: Extent = Extent { min: Vec3A::INFINITY, max: Vec3A::NEG_INFINITY };

    fn add(&mut self, min: Vec3A, max: Vec3A) {
        self.min = self.min.min(min);
        self.max = self.max.max(max);
    }

    /// Half the surface area.
    fn half_area(&self) -> f32 {
        let d = self.max - self.min;
        d.x * d.y + d.y * d.z + d.z * d.x
    }
}

impl From<Extent> for Bounds {
    fn from(extent: Extent) -> Bounds {
        Bounds { min: extent.min.into(), max: extent.max.into() }
    }
}

/// One or more primitives, with the box around them and the box around their middles.
pub struct Group<'a> {
    pub items: &'a mut [Item],
    pub bounds: Extent,
    middles: Extent,
}

/// A plane between two bins of an axis.
struct Cut {
    axis: usize,
    low: f32,
    scale: f32,
    bin: f32,
}

impl<'a> Group<'a> {
    pub fn new(items: &'a mut [Item]) -> Group<'a> {
        let (mut bounds, mut middles) = (Extent::EMPTY, Extent::EMPTY);
        for item in items.iter() {
            bounds.add(item.min.into(), item.max.into());
            middles.add(item.middle(), item.middle());
        }
        Group { items, bounds, middles }
    }

    /// Splits at the cut with the least cost. A small group needs only few bins.
    pub fn split(self, quality: Quality) -> [Group<'a>; 2] {
        let cut = match (self.items.len(), quality) {
            (0..=2, _) => None,
            (3..=6, _) => self.best::<4>(),
            (7..=24, _) => self.best::<8>(),
            (_, Quality::Medium) => self.best::<16>(),
            (_, Quality::Best) => self.best::<32>(),
        };
        match cut {
            Some(cut) => self.partition(&cut),
            None => self.halve(),
        }
    }

    /// Splits into two halves along the longest axis.
    pub fn halve(self) -> [Group<'a>; 2] {
        let extent = self.middles.max - self.middles.min;
        let axis = (0..3).max_by(|&a, &b| extent[a].total_cmp(&extent[b])).unwrap_or(0);
        let half = self.items.len() / 2;
        self.items.select_nth_unstable_by(half, |a, b| a.middle()[axis].total_cmp(&b.middle()[axis]));
        let (low, high) = self.items.split_at_mut(half);
        [Group::new(low), Group::new(high)]
    }

    /// The cut with the least cost. None if all middles are in one bin, or if surfaces are zero or infinite.
    fn best<const BINS: usize>(&self) -> Option<Cut> {
        let extent = self.middles.max - self.middles.min;
        // Slightly less than the number of bins, so that the last middle is in the last bin.
        let scale = Vec3A::splat(BINS as f32 * (1.0 - 1e-6)) / extent;
        let scale = Vec3A::select(scale.is_finite_mask(), scale, Vec3A::ZERO);
        let bins = self.bins::<BINS>(scale);
        let mut best: Option<(f32, Cut)> = None;
        for axis in 0..3 {
            // The costs above each cut, from the top down; then the costs below, from the bottom up.
            let mut above = [0.0; BINS];
            let (mut extent, mut items) = (Extent::EMPTY, 0);
            for bin in (1..BINS).rev() {
                let (bounds, count) = bins[axis][bin];
                extent.add(bounds.min, bounds.max);
                items += count;
                above[bin] = cost(&extent, items);
            }
            let (mut extent, mut items) = (Extent::EMPTY, 0);
            for bin in 1..BINS {
                let (bounds, count) = bins[axis][bin - 1];
                extent.add(bounds.min, bounds.max);
                items += count;
                let cost = cost(&extent, items) + above[bin];
                if cost < best.as_ref().map_or(f32::INFINITY, |(least, _)| *least) {
                    let cut = Cut { axis, low: self.middles.min[axis], scale: scale[axis], bin: bin as f32 };
                    best = Some((cost, cut));
                }
            }
        }
        best.filter(|(cost, _)| *cost > 0.0).map(|(_, cut)| cut)
    }

    /// For each bin, the box around its primitives and their number.
    fn bins<const BINS: usize>(&self, scale: Vec3A) -> [[(Extent, u32); BINS]; 3] {
        let mut bins = [[(Extent::EMPTY, 0); BINS]; 3];
        for item in self.items.iter() {
            let position = ((item.middle() - self.middles.min) * scale).to_array();
            for axis in 0..3 {
                let (extent, count) = &mut bins[axis][(position[axis] as i32 as usize).min(BINS - 1)];
                extent.add(item.min.into(), item.max.into());
                *count += 1;
            }
        }
        bins
    }

    /// The groups on either side of a cut.
    fn partition(self, cut: &Cut) -> [Group<'a>; 2] {
        let mut sides = [(Extent::EMPTY, Extent::EMPTY); 2];
        let (mut low, mut high) = (0, self.items.len());
        while low < high {
            let item = self.items[low];
            let middle = item.middle();
            // Exactly the arithmetic of the choice of the bin.
            let above = (middle[cut.axis] - cut.low) * cut.scale >= cut.bin;
            let (bounds, middles) = &mut sides[usize::from(above)];
            bounds.add(item.min.into(), item.max.into());
            middles.add(middle, middle);
            if above {
                high -= 1;
                self.items.swap(low, high);
            } else {
                low += 1;
            }
        }
        let (below, above) = self.items.split_at_mut(low);
        let [(bounds, middles), (bounds_above, middles_above)] = sides;
        [Group { items: below, bounds, middles }, Group { items: above, bounds: bounds_above, middles: middles_above }]
    }
}

/// The cost of a group under the surface area heuristic, up to a constant factor: half its surface times its number of
/// primitives; infinite if the group is empty.
fn cost(extent: &Extent, items: u32) -> f32 {
    match items {
        0 => f32::INFINITY,
        _ => extent.half_area() * items as f32,
    }
}

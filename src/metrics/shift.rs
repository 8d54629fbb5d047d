//! Tests whether one image is shifted against the other, where the noise of single pixels is unknown.
//!
//! Images that are a part of a pixel apart differ by that part of their gradient. So in each tile the differences a − b are correlated with
//! the gradient of (a + b) / 2, less its mean over the tile, which a difference of brightness looks like. Exchanging both images in a pixel
//! changes the sign of its difference and keeps (a + b) / 2. If their noise is of one kind and independent from pixel to pixel, this is as
//! likely, and so the sign of each tile's correlation r is that of a coin: Σ r / √Σ r² exceeds t with a probability of at most
//! 2 e^(-t²/2) (Hoeffding, JASA 58(301), 1963). Noise that neighbours share, as after a wide filter or a denoiser, has no
//! direction, so that r has the mean 0, and a sign of its own in each tile that is larger than the filter.

use super::estimate::corrected;
use super::grid::Grid;
use super::images::{Images, Quantity};

/// The share of the false alarms, of each axis the half: that of samples' variances, which are then unknown.
const SHARE: f64 = 1.0 / 12.0;

/// Sums over a tile of differences d and gradients g.
#[derive(Clone, Copy, Default)]
struct TileSums {
    pixels: f64,
    d: f64,
    g: f64,
    dd: f64,
    dg: f64,
    gg: f64,
}

impl TileSums {
    fn add(&mut self, d: f64, g: f64) {
        self.pixels += 1.0;
        self.d += d;
        self.g += g;
        self.dd += d * d;
        self.dg += d * g;
        self.gg += g * g;
    }

    /// The correlation; 0 if there is no difference or no gradient but that of all of the tile.
    fn correlation(&self) -> f64 {
        let spread = self.gg - self.g * self.g / self.pixels;
        let size = (self.dd * spread).sqrt();
        // Equal gradients leave rounding.
        if size > 0.0 && spread > 1e-9 * self.gg { (self.dg - self.d * self.g / self.pixels) / size } else { 0.0 }
    }
}

/// The p-value of a shift along either axis, corrected for both and for the other tests.
pub(super) fn p(images: &Images<'_>, grid: &Grid) -> f64 {
    let (width, height) = (images.width, images.height);
    let along = |[right, down]: [usize; 2]| {
        let mut tiles = vec![TileSums::default(); grid.tiles()];
        for y in down..height.saturating_sub(down) {
            for x in right..width.saturating_sub(right) {
                let (pixel, step) = (y * width + x, down * width + right);
                let all = [pixel - step, pixel, pixel + step];
                if all.into_iter().all(|pixel| images.counts(pixel)) {
                    let [before, own, after] = all.map(|pixel| images.values(Quantity::Luminance, pixel));
                    tiles[grid.tile_of(pixel)].add(own[0] - own[1], after[0] + after[1] - before[0] - before[1]);
                }
            }
        }
        let found: Vec<f64> = tiles.iter().map(TileSums::correlation).collect();
        let squares: f64 = found.iter().map(|r| r * r).sum();
        let t = if squares > 0.0 { found.iter().sum::<f64>() / squares.sqrt() } else { 0.0 };
        corrected((2.0 * (-0.5 * t * t).exp()).min(1.0), 0.5 * SHARE)
    };
    f64::min(along([1, 0]), along([0, 1]))
}

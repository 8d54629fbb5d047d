//! Tests whether two images differ by more than noise: in all of the image, in one colour, in one region, or in single pixels ([`super::pixels`]).
//!
//! It compares the means of luminance, red, green and blue over all of the image, and over each tile of a grid. Every
//! mean difference has a standard error with a known number of degrees of freedom. Student's t gives its p-value: the
//! probability that noise alone makes a difference of at least this size. docs/comparing.md has the derivation and
//! measurements.

use super::estimate::{Estimate, corrected, degrees_of_sum};
use super::grid::{CELLS, Grid};
use super::images::{Images, QUANTITIES, Quantity};
use super::pixels::{Pixels, pixels};

/// The shift of a mean, in its standard errors, if the largest one, two or three of [`CELLS`]² normal numbers are
/// removed: the sums of their expectations, 1.766 + 1.285 + 0.990, over √15, √14 and √13.
const TAKEN: [f64; 3] = [0.456, 0.815, 1.121];
/// If a cell differs by more than this many of its standard errors, these may be wrong. In a tile of sixteen cells,
/// three cells that differ by less make 3.8 standard errors of the tile; a significant tile among 64 needs 4.3.
const DOUBTFUL: f64 = 5.0;
/// With fewer tiles than this, cells are the replicates of all of the image.
const ENOUGH_TILES: usize = 32;
/// Two images share their noise if a smaller share of their pixels differs by more than the standard error. For
/// independent images it is a third to a half (for a normal variable over its standard deviation, known or estimated
/// from one square).
const SHARED: f64 = 0.16;
/// With fewer noisy pixels than this, shared noise is not detected.
const ENOUGH_PIXELS: usize = 64;

/// Each test's share of the false alarms: the mean luminance, the mean of each colour, and all tiles together. The tests of single pixels
/// have the rest.
const SHARE_LUMINANCE: f64 = 0.5;
const SHARE_COLOUR: f64 = 1.0 / 18.0;
const SHARE_TILES: f64 = 1.0 / 6.0;

/// The source of the standard errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorSource {
    /// The variances in the files.
    Variances,
    /// The spread of the paired differences a − b over the image.
    Pairs,
    /// The spread of the paired differences, although the files have variances: the pixels differ by much less than these, as in
    /// images that share random numbers.
    SharedNoise,
}

/// A mean difference a − b.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeanDifference {
    pub difference: Estimate,
    /// The mean of b over the same pixels.
    pub reference: f64,
}

/// The most significant difference of a tile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Local {
    /// The tile in pixels: left, top, width, height.
    pub tile: [usize; 4],
    pub quantity: Quantity,
    pub estimate: MeanDifference,
    /// Its p-value, corrected for the number of tiles and for the other tests.
    pub p: f64,
}

/// Mean differences in the order of [`QUANTITIES`], with p-values that are corrected like [`Local::p`].
pub type Means = [(MeanDifference, f64); 4];

/// The result of the comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    pub source: ErrorSource,
    /// Whether all pixels that count are equal in both images.
    pub identical: bool,
    pub means: Means,
    /// If few pixels rule the noise of both images: their number, and the means without them. These means are tested
    /// instead of those of all of the image.
    pub rest: Option<(usize, Means)>,
    /// None if the image is a single tile.
    pub local: Option<Local>,
    pub pixels: Pixels,
    /// The p-value of all tests together: the smallest of theirs.
    pub p: f64,
}

/// Sums of one quantity over a cell, a tile or all of the image.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    pixels: f64,
    difference: f64,
    reference: f64,
    /// Σ v and Σ v².
    variance: f64,
    variance2: f64,
}

impl Sums {
    fn add(&mut self, other: &Sums) {
        self.pixels += other.pixels;
        self.difference += other.difference;
        self.reference += other.reference;
        self.variance += other.variance;
        self.variance2 += other.variance2;
    }

    fn total(parts: &[Sums]) -> Sums {
        parts.iter().fold(Sums::default(), |mut sums, part| {
            sums.add(part);
            sums
        })
    }

    fn mean(&self) -> f64 {
        self.difference / self.pixels
    }

    /// The standard error from rounding to f32, which remains even without noise.
    fn rounding(&self) -> f64 {
        f64::from(f32::EPSILON) * ((self.reference / self.pixels).abs() + self.mean().abs())
    }

    /// The variance of the mean from the pixels' variances. Each variance has at least one degree of freedom, from two
    /// halves. If few bright pixels dominate the sum, the sum has few degrees of freedom.
    fn noise_by_variances(&self) -> MeanVariance {
        MeanVariance {
            variance: self.variance / (self.pixels * self.pixels),
            degrees: degrees_of_sum(self.variance, self.variance2),
        }
    }

    /// The contribution of each part's mean m to the spread around the image's mean M, by its share n/N of the pixels:
    /// (n/N)² (m − M)².
    fn squares(&self, parts: &[Sums]) -> Vec<f64> {
        let filled = parts.iter().filter(|part| part.pixels > 0.0);
        filled.map(|part| (part.pixels / self.pixels * (part.mean() - self.mean())).powi(2)).collect()
    }

    /// The variance of the mean from the spread of J parts: the sum of [`Sums::squares`] times J/(J − 1).
    fn noise_by_parts(&self, parts: &[Sums]) -> MeanVariance {
        let squares = self.squares(parts);
        let count = squares.len() as f64;
        match count > 1.0 {
            true => {
                MeanVariance { variance: squares.iter().sum::<f64>() * count / (count - 1.0), degrees: count - 1.0 }
            }
            false => MeanVariance { variance: f64::INFINITY, degrees: 1.0 },
        }
    }

    /// The variance of the mean from the parts, if a single part may hold most of the noise, as with a rare bright pixel. The degrees of freedom are
    /// then at most those of a sum of squares with one degree each.
    fn noise_by_uneven_parts(&self, parts: &[Sums]) -> MeanVariance {
        let squares = self.squares(parts);
        let of_sum = degrees_of_sum(squares.iter().sum(), squares.iter().map(|square| square * square).sum());
        let even = self.noise_by_parts(parts);
        MeanVariance { degrees: even.degrees.min(of_sum), ..even }
    }

    /// The variance of the mean of a tile, or of a part of it, from its pixels' variances or from its cells.
    fn noise(&self, cells: &[Sums], source: ErrorSource) -> MeanVariance {
        match source {
            ErrorSource::Variances => self.noise_by_variances(),
            ErrorSource::Pairs | ErrorSource::SharedNoise => self.noise_by_parts(cells),
        }
    }

    fn estimate(&self, noise: MeanVariance) -> Estimate {
        let error = (noise.variance + self.rounding().powi(2)).sqrt();
        Estimate {
            value: self.mean(),
            error: if self.difference == 0.0 && noise.variance == 0.0 { 0.0 } else { error },
            degrees: noise.degrees,
        }
    }

    fn against_reference(&self, difference: Estimate) -> MeanDifference {
        MeanDifference { difference, reference: self.reference / self.pixels }
    }
}

/// The variance of a mean, and its degrees of freedom.
#[derive(Clone, Copy, Debug)]
struct MeanVariance {
    variance: f64,
    degrees: f64,
}

/// The sums of a quantity in each cell of each tile, without the pixels in `out`.
fn sums_of_cells(grid: &Grid, images: &Images<'_>, quantity: Quantity, out: &[usize]) -> Vec<[Sums; CELLS * CELLS]> {
    let mut cells = vec![[Sums::default(); CELLS * CELLS]; grid.tiles()];
    let columns: Vec<_> = (0..grid.width).map(|x| Grid::part(x, grid.width, grid.columns)).collect();
    for y in 0..grid.height {
        let (row, cell_row) = Grid::part(y, grid.height, grid.rows);
        for (x, (column, cell_column)) in columns.iter().enumerate() {
            let pixel = y * grid.width + x;
            if !images.counts(pixel) || out.contains(&pixel) {
                continue;
            }
            let [a, b] = images.values(quantity, pixel);
            let variance = images.variance(quantity, pixel).unwrap_or(0.0);
            cells[row * grid.columns + column][cell_row * CELLS + cell_column].add(&Sums {
                pixels: 1.0,
                difference: a - b,
                reference: b,
                variance,
                variance2: variance * variance,
            });
        }
    }
    cells
}

/// The sums of one quantity at every scale.
struct Scales {
    cells: Vec<[Sums; CELLS * CELLS]>,
    tiles: Vec<Sums>,
    image: Sums,
}

impl Scales {
    /// The sums of a quantity without the pixels in `out`.
    fn new(grid: &Grid, images: &Images<'_>, quantity: Quantity, out: &[usize]) -> Scales {
        let cells = sums_of_cells(grid, images, quantity, out);
        let tiles: Vec<Sums> = cells.iter().map(|cells| Sums::total(cells)).collect();
        let image = Sums::total(&tiles);
        Scales { cells, tiles, image }
    }

    /// The mean difference of all of the image and its p-value.
    ///
    /// A pixel whose two halves agree by chance seems to have no noise. If it holds most of the image's noise, this
    /// noise is missing in the sum of variances, and the degrees of freedom do not show that one pixel dominates. But
    /// the difference of this pixel is in the mean as well as in the spread of the cells. So a mean must differ by both
    /// standard errors, and the wider interval is reported. If a difference comes from k cells, it is at most √k
    /// standard errors by their spread, whatever their values. And if both signs of a cell's difference are equally
    /// likely, as for two renders of one kind, t standard errors have a probability of at most 2 e^(-t²/2), whatever
    /// the sizes of the differences (Hoeffding, JASA 58(301), 1963).
    fn mean(&self, source: ErrorSource) -> (Estimate, f64) {
        // Tiles are better replicates than pixels: a filter wider than a pixel correlates neighbours, but nearly all
        // such pairs are within one tile. The variances assume independent pixels in any case.
        let by_tiles = source != ErrorSource::Variances && self.tiles.len() >= ENOUGH_TILES;
        let parts = if by_tiles { &self.tiles } else { self.cells.as_flattened() };
        let pairs = self.image.estimate(self.image.noise_by_uneven_parts(parts));
        if source != ErrorSource::Variances {
            return (pairs, pairs.p());
        }
        let variances = self.image.estimate(self.image.noise_by_variances());
        let wider = if variances.half_width() > pairs.half_width() { variances } else { pairs };
        (wider, f64::max(variances.p(), pairs.p()))
    }

    /// The noise of each tile; none for tiles without finite pixels.
    fn tile_noise(&self, source: ErrorSource) -> Vec<Option<MeanVariance>> {
        let of =
            |(tile, cells): (&Sums, &[Sums; CELLS * CELLS])| (tile.pixels > 0.0).then(|| tile.noise(cells, source));
        self.tiles.iter().zip(&self.cells).map(of).collect()
    }

    /// A tile without the cell that contributes most to its difference, and without the next two if they differ by far
    /// more than their standard errors. Also returns the shift of the mean that this removal causes in pure noise.
    fn without_worst_cells(&self, tile: usize, source: ErrorSource) -> (Sums, Vec<Sums>, f64) {
        let sign = self.tiles[tile].difference.signum();
        let mut cells: Vec<Sums> = self.cells[tile].iter().copied().filter(|cell| cell.pixels > 0.0).collect();
        cells.sort_by(|a, b| f64::total_cmp(&(sign * a.difference), &(sign * b.difference)));
        cells.pop();
        let doubtful = |cell: &Sums| {
            source == ErrorSource::Variances && cell.difference.powi(2) > DOUBTFUL.powi(2) * cell.variance
        };
        let mut taken = 0;
        while taken < TAKEN.len() - 1 && cells.pop_if(|cell| doubtful(cell)).is_some() {
            taken += 1;
        }
        (Sums::total(&cells), cells, TAKEN[taken])
    }
}

/// Compares the images. None if no pixel is finite in both.
pub fn difference(images: &Images<'_>) -> Option<Difference> {
    let mut counted = images.counted().peekable();
    counted.peek()?;
    let identical = counted.all(|pixel| images.a[pixel] == images.b[pixel]);
    let grid = Grid::new(images.width, images.height);
    let scales = |out: &[usize]| QUANTITIES.map(|quantity| Scales::new(&grid, images, quantity, out));
    let source = source(images);
    let means = |scales: &[Scales; 4]| {
        [0, 1, 2, 3].map(|i| {
            let (estimate, p) = scales[i].mean(source);
            (
                scales[i].image.against_reference(estimate),
                corrected(p, if i == 0 { SHARE_LUMINANCE } else { SHARE_COLOUR }),
            )
        })
    };
    let all = scales(&[]);
    let means_of_all = means(&all);
    let ruling = images.ruling();
    let rest = (!ruling.is_empty()).then(|| (ruling.len(), means(&scales(&ruling))));
    let local = (grid.tiles() > 1).then(|| local(&grid, &all, source)).flatten();
    let tested = rest.map_or(means_of_all, |(_, means)| means);
    let pixels = pixels(images, &grid);
    let others = local.map(|local| local.p).into_iter().chain([pixels.p()]);
    let least = tested.iter().map(|(_, p)| *p).chain(others).fold(1.0, f64::min);
    Some(Difference { source, identical, means: means_of_all, rest, local, pixels, p: least })
}

/// Chooses the source of the standard errors. Each pixel has one vote, because few pixels would dominate a sum of squares.
fn source(images: &Images<'_>) -> ErrorSource {
    if images.variances.is_none() {
        return ErrorSource::Pairs;
    }
    let (mut noisy, mut beyond) = (0, 0);
    for pixel in images.counted() {
        let [a, b] = images.values(Quantity::Luminance, pixel);
        let variance = images.variance(Quantity::Luminance, pixel).unwrap_or(0.0);
        noisy += usize::from(variance > 0.0);
        beyond += usize::from(variance > 0.0 && (a - b) * (a - b) > variance);
    }
    match noisy >= ENOUGH_PIXELS && (beyond as f64) < SHARED * noisy as f64 {
        true => ErrorSource::SharedNoise,
        false => ErrorSource::Variances,
    }
}

/// The most significant tile.
///
/// The noise of a tile is at least that of the tiles around it: if rare paths have missed a tile, it is too dark and
/// looks free of noise, but they have reached its neighbours. A tile must also differ without its worst cells: if the
/// two halves of a pixel agree by chance, its variance is far too small, and such pixels may hold most of a tile's
/// noise. They are often neighbours, for example along the edge of a lamp. If the halves of each pixel agree in half of
/// the images, and such pixels are as often too bright as too dark, four pixels that all agree and deviate to the same
/// side occur in 0.8 % of the images; more are rarer.
fn local(grid: &Grid, scales: &[Scales; 4], source: ErrorSource) -> Option<Local> {
    let share = SHARE_TILES / (QUANTITIES.len() * grid.tiles()) as f64;
    let mut worst: Option<Local> = None;
    for (quantity, scales) in QUANTITIES.into_iter().zip(scales) {
        let noise = scales.tile_noise(source);
        for (tile, sums) in scales.tiles.iter().enumerate() {
            let Some(own) = noise[tile] else { continue };
            let near = grid.around(tile).filter_map(|near| Some((scales.tiles[near].pixels, noise[near]?)));
            // The variance of a pixel, not of a mean, since tiles differ in size.
            let (total, count) =
                near.fold((0.0, 0.0), |(total, count), (pixels, noise)| (total + noise.variance * pixels, count + 1.0));
            let estimate = |sums: &Sums, own: MeanVariance| {
                let variance = own.variance.max(total / count / sums.pixels);
                sums.estimate(MeanVariance { variance, degrees: own.degrees })
            };
            let own_estimate = estimate(sums, own);
            let p = corrected(own_estimate.p(), share);
            if worst.is_some_and(|worst| p >= worst.p) {
                continue;
            }
            let (rest, cells, taken) = scales.without_worst_cells(tile, source);
            let p = match rest.pixels > 0.0 && rest.difference * sums.difference > 0.0 {
                true => {
                    let mut rest = estimate(&rest, rest.noise(&cells, source));
                    rest.value += taken * rest.error.copysign(rest.value);
                    p.max(corrected(rest.p(), share))
                }
                false => 1.0,
            };
            if worst.is_none_or(|worst| p < worst.p) {
                worst = Some(Local {
                    tile: grid.rectangle(tile),
                    quantity,
                    estimate: sums.against_reference(own_estimate),
                    p,
                });
            }
        }
    }
    worst
}

//! Whether the difference of two images is more than noise: on the whole, in one colour, or in one place.
//!
//! It compares the means of luminance, red, green and blue over the whole image, and over each tile of a grid.
//! Every mean difference comes with a standard error of a known number of degrees of freedom, and so with a p-value by Student's t:
//! the probability that noise alone makes a difference of at least this size. docs/comparing.md has the derivation and measurements.

use super::estimate::{Estimate, degrees_of_sum};
use crate::data::luminance;

/// Differences with a p-value below this are called more than noise.
pub const LEVEL: f64 = 0.01;

/// The least and the largest side of a tile in pixels.
const TILE: (usize, usize) = (4, 16);
/// Cells along each side of a tile.
const CELLS: usize = 4;
/// What the largest one, two and three of [`CELLS`]² normal numbers take from the mean of the others, in standard errors of that: the
/// sums of their expectations, 1.766 + 1.285 + 0.990, over √15, √14 and √13.
const TAKEN: [f64; 3] = [0.456, 0.815, 1.121];
/// A cell that differs by more than this many of its standard errors may be wrong about them. Three that differ by less, in a tile of
/// sixteen, make 3.8 standard errors of it: fewer than the 4.3 that one of 64 tiles takes.
const DOUBTFUL: f64 = 5.0;
/// With fewer tiles than this, cells are the replicates of the whole image.
const ENOUGH_TILES: usize = 32;
/// The share of pixels that differ by more than their standard error, below which two images are said to share their noise. Of
/// independent ones it is a third to a half (of a normal variable over its standard deviation, known or estimated by one square).
const SHARED: f64 = 0.16;
/// Fewer noisy pixels than this do not tell.
const ENOUGH_PIXELS: usize = 64;
/// A pixel rules the noise if it holds more than this share of it in each image. (Of 256 squares of normal numbers, as even noise has them,
/// one does in 4 images of 1e6.)
const RULING: f64 = 0.125;
/// At most this many pixels may rule, and at most one of this many.
const FEW: usize = 16;

/// How the tests share the false alarms: the mean luminance, the mean of each colour, and all tiles together.
const SHARE_LUMINANCE: f64 = 0.5;
const SHARE_COLOUR: f64 = 1.0 / 18.0;
const SHARE_TILES: f64 = 1.0 / 3.0;

/// A quantity of pixels that is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    Luminance,
    Red,
    Green,
    Blue,
}

pub const QUANTITIES: [Quantity; 4] = [Quantity::Luminance, Quantity::Red, Quantity::Green, Quantity::Blue];

impl Quantity {
    fn of(self, rgb: [f64; 3]) -> f64 {
        match self {
            Quantity::Luminance => luminance(rgb),
            Quantity::Red => rgb[0],
            Quantity::Green => rgb[1],
            Quantity::Blue => rgb[2],
        }
    }

    pub fn name(self) -> &'static str {
        match self {
            Quantity::Luminance => "luminance",
            Quantity::Red => "red",
            Quantity::Green => "green",
            Quantity::Blue => "blue",
        }
    }
}

/// Two images of one size. Radiance, row 0 on top.
#[derive(Clone, Copy, Debug)]
pub struct Images<'a> {
    pub width: usize,
    pub height: usize,
    pub a: &'a [[f32; 3]],
    /// The reference.
    pub b: &'a [[f32; 3]],
    /// Variances of the pixels' values in a and in b, where both are known.
    pub variances: Option<[&'a [[f32; 3]]; 2]>,
}

impl Images<'_> {
    /// Whether the pixel counts: it is finite in both.
    pub fn counts(&self, pixel: usize) -> bool {
        self.a[pixel].iter().chain(&self.b[pixel]).all(|v| v.is_finite())
    }

    /// The variances of a quantity at a pixel of a and of b. How the channels of a pixel vary together is not known: as one, which is the
    /// most that they can, and nearly what they do where paths carry all three (Cauchy and Schwarz: Var Σ w c ≤ (Σ w σ)²).
    fn variances(&self, quantity: Quantity, pixel: usize) -> Option<[f64; 2]> {
        let of = |variance: &[[f32; 3]]| quantity.of(variance[pixel].map(|v| f64::from(v).sqrt())).powi(2);
        self.variances.map(|images| images.map(of))
    }

    /// The variance of a quantity's difference at a pixel.
    fn variance(&self, quantity: Quantity, pixel: usize) -> Option<f64> {
        self.variances(quantity, pixel).map(|[a, b]| a + b)
    }

    /// The few pixels that rule the noise of both images. Their chance values decide the mean, and hide the other pixels. A pixel that is
    /// noisy in one image alone may have met a rare path there, and leaving it out would darken that image. None without
    /// variances, or where many pixels share the noise.
    fn ruling(&self) -> Vec<usize> {
        let pixels = (0..self.width * self.height).filter(|&pixel| self.counts(pixel));
        let known = pixels.filter_map(|pixel| Some((pixel, self.variances(Quantity::Luminance, pixel)?)));
        let mut left: Vec<(usize, [f64; 2])> = known.collect();
        let few = FEW.min(left.len() / FEW);
        let mut ruling = Vec::new();
        loop {
            let least = [0, 1].map(|image| RULING * left.iter().map(|(_, noise)| noise[image]).sum::<f64>());
            let (rule, rest): (Vec<_>, Vec<_>) =
                left.iter().partition(|(_, noise)| noise[0] > least[0] && noise[1] > least[1]);
            if rule.is_empty() {
                return ruling;
            }
            ruling.extend(rule.iter().map(|(pixel, _)| pixel));
            if ruling.len() > few {
                return Vec::new();
            }
            left = rest;
        }
    }
}

/// The source of the standard errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorSource {
    /// The variances in the files.
    Variances,
    /// How the paired differences a − b are spread over the image.
    Pairs,
    /// The same, although the files have variances: pixels differ by much less than these say, as in images that share random numbers.
    SharedNoise,
}

/// A mean difference a − b.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeanDifference {
    pub difference: Estimate,
    /// The mean of b there.
    pub reference: f64,
}

/// The most significant difference in a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Local {
    /// The tile in pixels: left, top, width, height.
    pub tile: [usize; 4],
    pub quantity: Quantity,
    pub estimate: MeanDifference,
    /// As if it were the only test: corrected for how many tiles there are, and for the tests beside.
    pub p: f64,
}

/// Mean differences in the order of [`QUANTITIES`], each with a p-value as of [`Local::p`].
pub type Means = [(MeanDifference, f64); 4];

/// The result of the comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    pub source: ErrorSource,
    /// Every pixel that counts is the same in both.
    pub identical: bool,
    pub means: Means,
    /// Where few pixels rule the noise of both images: how many, and the means without them. These are tested in place of the whole's.
    pub rest: Option<(usize, Means)>,
    /// Nothing where the image is a single tile.
    pub local: Option<Local>,
    /// Of all tests together: the least of theirs.
    pub p: f64,
}

/// Sums over a cell, a tile or the whole, of one quantity.
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

    fn of(parts: &[Sums]) -> Sums {
        parts.iter().fold(Sums::default(), |mut sums, part| {
            sums.add(part);
            sums
        })
    }

    fn mean(&self) -> f64 {
        self.difference / self.pixels
    }

    /// A standard error that rounding to f32 leaves in any case, even where there is no noise.
    fn rounding(&self) -> f64 {
        f64::from(f32::EPSILON) * ((self.reference / self.pixels).abs() + self.mean().abs())
    }

    /// From the pixels' variances: their sum. Each has one degree of freedom at least, of two halves. Where few bright pixels make the sum,
    /// it has few degrees of freedom.
    fn noise_by_variances(&self) -> MeanVariance {
        MeanVariance {
            variance: self.variance / (self.pixels * self.pixels),
            degrees: degrees_of_sum(self.variance, self.variance2),
        }
    }

    /// What the mean of each part adds to the spread around the whole's, by its share of the pixels: (n/N)² (m − M)².
    fn squares(&self, parts: &[Sums]) -> Vec<f64> {
        let filled = parts.iter().filter(|part| part.pixels > 0.0);
        filled.map(|part| (part.pixels / self.pixels * (part.mean() - self.mean())).powi(2)).collect()
    }

    /// From that spread: its sum times J/(J − 1), J being the number of parts.
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

    /// The same where a part may hold most of the noise, as a rare bright pixel does: no more degrees of freedom than a sum of squares of
    /// one each has.
    fn noise_by_uneven_parts(&self, parts: &[Sums]) -> MeanVariance {
        let squares = self.squares(parts);
        let of_sum = degrees_of_sum(squares.iter().sum(), squares.iter().map(|square| square * square).sum());
        let even = self.noise_by_parts(parts);
        MeanVariance { degrees: even.degrees.min(of_sum), ..even }
    }

    /// Of a tile or what is left of one, by its pixels' variances or by its cells.
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

/// The variance of a mean, and how well it is known.
#[derive(Clone, Copy, Debug)]
struct MeanVariance {
    variance: f64,
    degrees: f64,
}

/// Tiles of nearly equal size that cover the image, of [`CELLS`] × [`CELLS`] cells each.
struct Grid {
    width: usize,
    height: usize,
    columns: usize,
    rows: usize,
}

impl Grid {
    /// 64 tiles, as long as these have a side of 4 to 16 pixels.
    fn new(width: usize, height: usize) -> Grid {
        let side = ((width * height) as f64).sqrt() / 8.0;
        let side = (side as usize).clamp(TILE.0, TILE.1);
        Grid { width, height, columns: (width / side).max(1), rows: (height / side).max(1) }
    }

    fn tiles(&self) -> usize {
        self.columns * self.rows
    }

    /// Where a pixel lies along an axis of `length` pixels: its tile, and its cell in that.
    fn part(at: usize, length: usize, tiles: usize) -> (usize, usize) {
        let cell = at * tiles * CELLS / length;
        (cell / CELLS, cell % CELLS)
    }

    /// Left, top, width and height of a tile.
    fn place(&self, tile: usize) -> [usize; 4] {
        let edge = |at: usize, length: usize, tiles: usize| (at * length).div_ceil(tiles);
        let (column, row) = (tile % self.columns, tile / self.columns);
        let (left, top) = (edge(column, self.width, self.columns), edge(row, self.height, self.rows));
        let (right, bottom) = (edge(column + 1, self.width, self.columns), edge(row + 1, self.height, self.rows));
        [left, top, right - left, bottom - top]
    }

    /// A tile and those around it.
    fn around(&self, tile: usize) -> impl Iterator<Item = usize> + '_ {
        let (column, row) = (tile % self.columns, tile / self.columns);
        let near = |at: usize, count: usize| at.saturating_sub(1)..(at + 2).min(count);
        near(row, self.rows)
            .flat_map(move |row| near(column, self.columns).map(move |column| row * self.columns + column))
    }

    /// The sums of a quantity in each cell, tile by tile, without the pixels that are left out.
    fn sums(&self, images: &Images<'_>, quantity: Quantity, out: &[usize]) -> Vec<[Sums; CELLS * CELLS]> {
        let mut cells = vec![[Sums::default(); CELLS * CELLS]; self.tiles()];
        let columns: Vec<_> = (0..self.width).map(|x| Grid::part(x, self.width, self.columns)).collect();
        for y in 0..self.height {
            let (row, cell_row) = Grid::part(y, self.height, self.rows);
            for (x, (column, cell_column)) in columns.iter().enumerate() {
                let pixel = y * self.width + x;
                if !images.counts(pixel) || out.contains(&pixel) {
                    continue;
                }
                let [a, b] = [images.a, images.b].map(|image| quantity.of(image[pixel].map(f64::from)));
                let variance = images.variance(quantity, pixel).unwrap_or(0.0);
                cells[row * self.columns + column][cell_row * CELLS + cell_column].add(&Sums {
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
}

/// The sums of one quantity at every scale.
struct Scales {
    cells: Vec<[Sums; CELLS * CELLS]>,
    tiles: Vec<Sums>,
    whole: Sums,
}

impl Scales {
    fn new(grid: &Grid, images: &Images<'_>, quantity: Quantity, out: &[usize]) -> Scales {
        let cells = grid.sums(images, quantity, out);
        let tiles: Vec<Sums> = cells.iter().map(|cells| Sums::of(cells)).collect();
        let whole = Sums::of(&tiles);
        Scales { cells, tiles, whole }
    }

    /// The mean difference of the whole, and how probable noise alone makes one at least as large.
    ///
    /// A pixel whose two halves agree by chance seems to have no noise. Where it holds most of the image's, it drops out of the sum of
    /// variances, and of the degrees of freedom, which would tell how much of the sum one pixel holds. But what it differs by is in the mean
    /// and in the spread of the cells alike. So a mean must differ by both, and the wider interval is stated. A difference that k cells
    /// make is √k of its errors by their spread at most, whatever they hold. And where both signs of a cell are as likely, as of two renders
    /// of one kind, t of these errors have a probability of 2 e^(-t²/2) at most, whatever the sizes are (Hoeffding, JASA 58(301), 1963).
    fn mean(&self, source: ErrorSource) -> (Estimate, f64) {
        // Tiles are better replicates than pixels: what neighbouring pixels have in common, by a filter wider than one of them, is within
        // a tile nearly all. Variances take pixels to be independent anyway.
        let by_tiles = source != ErrorSource::Variances && self.tiles.len() >= ENOUGH_TILES;
        let parts = if by_tiles { &self.tiles } else { self.cells.as_flattened() };
        let pairs = self.whole.estimate(self.whole.noise_by_uneven_parts(parts));
        if source != ErrorSource::Variances {
            return (pairs, pairs.p());
        }
        let variances = self.whole.estimate(self.whole.noise_by_variances());
        let wider = if variances.half_width() > pairs.half_width() { variances } else { pairs };
        (wider, f64::max(variances.p(), pairs.p()))
    }

    /// Of each tile that has pixels which count.
    fn tile_noise(&self, source: ErrorSource) -> Vec<Option<MeanVariance>> {
        let of =
            |(tile, cells): (&Sums, &[Sums; CELLS * CELLS])| (tile.pixels > 0.0).then(|| tile.noise(cells, source));
        self.tiles.iter().zip(&self.cells).map(of).collect()
    }

    /// A tile without the cell that makes most of its difference, and without the next two where they differ by more than their variances
    /// tell; with what taking so many away takes from noise alone.
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
        (Sums::of(&cells), cells, TAKEN[taken])
    }
}

/// Compares the images. None where no pixel is finite in both.
pub fn difference(images: &Images<'_>) -> Option<Difference> {
    let pixels = images.width * images.height;
    let mut counted = (0..pixels).filter(|&pixel| images.counts(pixel)).peekable();
    counted.peek()?;
    let identical = counted.all(|pixel| images.a[pixel] == images.b[pixel]);
    let grid = Grid::new(images.width, images.height);
    let scales = |out: &[usize]| QUANTITIES.map(|quantity| Scales::new(&grid, images, quantity, out));
    let source = source(images);
    let means = |scales: &[Scales; 4]| {
        [0, 1, 2, 3].map(|i| {
            let (estimate, p) = scales[i].mean(source);
            (
                scales[i].whole.against_reference(estimate),
                corrected(p, if i == 0 { SHARE_LUMINANCE } else { SHARE_COLOUR }),
            )
        })
    };
    let all = scales(&[]);
    let whole = means(&all);
    let ruling = images.ruling();
    let rest = (!ruling.is_empty()).then(|| (ruling.len(), means(&scales(&ruling))));
    let local = (grid.tiles() > 1).then(|| local(&grid, &all, source)).flatten();
    let tested = rest.map_or(whole, |(_, means)| means);
    let least = tested.iter().map(|(_, p)| *p).chain(local.map(|local| local.p)).fold(1.0, f64::min);
    Some(Difference { source, identical, means: whole, rest, local, p: least })
}

/// Chooses the source of the errors. Each pixel has one vote, because few pixels would decide a sum of squares.
fn source(images: &Images<'_>) -> ErrorSource {
    if images.variances.is_none() {
        return ErrorSource::Pairs;
    }
    let (mut noisy, mut beyond) = (0, 0);
    for pixel in (0..images.width * images.height).filter(|&pixel| images.counts(pixel)) {
        let of = |image: &[[f32; 3]]| luminance(image[pixel].map(f64::from));
        let variance = images.variance(Quantity::Luminance, pixel).unwrap_or(0.0);
        let difference = of(images.a) - of(images.b);
        noisy += usize::from(variance > 0.0);
        beyond += usize::from(variance > 0.0 && difference * difference > variance);
    }
    match noisy >= ENOUGH_PIXELS && (beyond as f64) < SHARED * noisy as f64 {
        true => ErrorSource::SharedNoise,
        false => ErrorSource::Variances,
    }
}

/// The p-value of one of many tests that has this share of the false alarms: with it, the probability of any p-value below x is x at
/// most, if the tests are independent or vary together (Šidák, JASA 62(318), 1967, with weights).
fn corrected(p: f64, share: f64) -> f64 {
    // 1 − (1 − p)^(1/share)
    -((-p).ln_1p() / share).exp_m1()
}

/// The tile that differs most.
///
/// Its noise is not taken to be less than that of the tiles around it: where a rare path has not met a tile, the tile is darker than it
/// should be and looks free of noise as well, but its neighbours have met it. And it must differ without its worst cells too: a pixel whose
/// two halves agree by chance has a variance that says nothing, and such pixels may hold most of a tile's noise. They come together, as along
/// the edge of a lamp. Where the halves of each agree in half of the images, and then deviate to one side as often as to the other, four that
/// all agree and all deviate to one side come in 0.8 % of images, and more are rarer.
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
            let whole = estimate(sums, own);
            let p = corrected(whole.p(), share);
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
                worst = Some(Local { tile: grid.place(tile), quantity, estimate: sums.against_reference(whole), p });
            }
        }
    }
    worst
}

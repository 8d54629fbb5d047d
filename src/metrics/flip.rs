//! LDR-FLIP: the perceived difference of two images that are shown in alternation.
//!
//! P. Andersson, J. Nilsson, T. Akenine-Möller, M. Oskarsson, K. Åström and M. D. Fairchild, "FLIP: A Difference
//! Evaluator for Alternating Images", Proceedings of the ACM on Computer Graphics and Interactive Techniques (HPG)
//! 3(2), 2020. Section and equation numbers are that paper's; constants are those of its table 1 and its supplement.
//! The tests compare with the authors' program.
//!
//! All kernels of the paper are sums of separable kernels, so that rows are filtered first and columns then. The image
//! is processed in bands of rows, so that the filtered rows stay in the caches and the memory does not grow with the
//! image.

use std::f64::consts::PI;
use std::ops::Range;

use crate::data::{product, unit};
use crate::threads::{cores, each};

/// Pixels per degree of a display that is 0.7 m away and shows 3840 pixels on 0.7 m, the paper's default (section 4): 67.02.
pub const PIXELS_PER_DEGREE: f64 = 0.7 * (3840.0 / 0.7) * (PI / 180.0);

/// The rows of a band. More rows need more memory; with fewer rows, more of them are filtered twice.
const BAND: usize = 64;

/// FLIP's error of each pixel, 0..1, with row 0 at the top, for two images in linear Rec. 709. They are clamped to 0..1
/// and not sRGB-encoded, because FLIP's first step is to decode. It is symmetric. NaN counts as 0. Edge pixels are
/// repeated outwards.
///
/// Each row has `width` pixels. If one image is longer, its additional pixels are ignored.
pub fn error_map(width: usize, a: &[[f32; 3]], b: &[[f32; 3]]) -> Vec<f32> {
    Flip::new(PIXELS_PER_DEGREE).error_map(width, a, b)
}

/// The mean error over a map; 0 of an empty one.
pub fn mean(map: &[f32]) -> f64 {
    map.iter().copied().map(f64::from).sum::<f64>() / map.len().max(1) as f64
}

/// A filter's weights at −radius … radius.
struct Filter(Vec<f64>);

impl Filter {
    fn new(radius: usize, weight: impl Fn(f64) -> f64) -> Filter {
        Filter((0..=2 * radius).map(|i| weight(i as f64 - radius as f64)).collect())
    }

    fn radius(&self) -> usize {
        self.0.len() / 2
    }

    fn sum(&self) -> f64 {
        self.0.iter().sum()
    }

    fn scaled(self, factor: f64) -> Filter {
        Filter(self.0.into_iter().map(|weight| weight * factor).collect())
    }

    /// The positive weights scaled to a sum of 1, the negative ones to −1 (section 4.2.1).
    fn balanced(self) -> Filter {
        let positive: f64 = self.0.iter().filter(|w| **w > 0.0).sum();
        let negative: f64 = -self.0.iter().filter(|w| **w < 0.0).sum::<f64>();
        Filter(self.0.into_iter().map(|w| if w > 0.0 { w / positive } else { w / negative }).collect())
    }

    /// The filter without the outer weights that are negligible relative to the middle one.
    fn cropped(self) -> Filter {
        const NOTHING: f64 = 1e-8;
        let (radius, least) = (self.radius(), NOTHING * self.0[self.radius()]);
        let cut = self.0[..radius].iter().take_while(|w| **w < least).count();
        Filter(self.0[cut..self.0.len() - cut].to_vec())
    }

    /// The weighted sum of rows of `width` values, one for each weight.
    fn weighted<'a>(&self, rows: impl Iterator<Item = &'a [f64]>, width: usize) -> Vec<f64> {
        let mut sums = vec![0.0; width];
        for (weight, row) in self.0.iter().zip(rows) {
            sums.iter_mut().zip(row).for_each(|(sum, value)| *sum += weight * value);
        }
        sums
    }
}

/// The filters for one pixel density.
struct Flip {
    /// The contrast sensitivity of the opponent channels: achromatic, red-green and blue-yellow. The last one is a sum
    /// of two filters (section 4.1.1, equation 4).
    colour: [Filter; 4],
    /// A Gaussian, and its balanced first and second derivatives (section 4.2.1).
    feature: [Filter; 3],
    /// The largest radius.
    margin: usize,
    /// The largest colour difference, which is that of green and blue (section 4.1.3).
    most: f64,
}

/// The row filters: four colour terms, then three of the features.
const TERMS: usize = 7;
/// The opponent channel that each term filters.
const CHANNEL: [usize; TERMS] = [0, 1, 2, 2, 0, 0, 0];

/// A filtered row of pixels, ready for comparison.
#[derive(Default)]
struct FilteredRow {
    /// L*, and a* and b* with Hunt's adjustment (section 4.1.2).
    lab: Vec<[f64; 3]>,
    /// Magnitudes of the gradient and of the second derivative.
    edge: Vec<f64>,
    point: Vec<f64>,
}

impl Flip {
    fn new(pixels_per_degree: f64) -> Flip {
        // Gaussian terms a √(π/b) exp(−π² x²/b), x in degrees: (a, b).
        let terms = [(1.0, 0.0047), (1.0, 0.0053), (34.1, 0.04), (13.5, 0.025)];
        let radius = |deviation: f64| (3.0 * deviation * pixels_per_degree).ceil() as usize;
        // One radius for all filters: three standard deviations of the widest.
        let colour_radius = radius((0.04_f64 / (2.0 * PI * PI)).sqrt());
        let gaussian = |(_, b): (f64, f64)| {
            let degrees = move |x: f64| x / pixels_per_degree;
            Filter::new(colour_radius, move |x| (-(PI * degrees(x)).powi(2) / b).exp())
        };
        // The weight of a term in two dimensions. Each direction gets its square root.
        let weight = |(a, b): (f64, f64)| a * (PI / b).sqrt();
        let total = |term| weight(term) * gaussian(term).sum().powi(2);
        let blue = total(terms[2]) + total(terms[3]);
        let totals = [total(terms[0]), total(terms[1]), blue, blue];
        let colour = [0, 1, 2, 3].map(|i| gaussian(terms[i]).scaled((weight(terms[i]) / totals[i]).sqrt()).cropped());

        // Half the width of a feature, 0.082 degrees.
        const FEATURE: f64 = 0.5 * 0.082;
        let deviation = FEATURE * pixels_per_degree;
        let bell = move |x: f64| (-x * x / (2.0 * deviation * deviation)).exp();
        let kernel = |weight: &dyn Fn(f64) -> f64| Filter::new(radius(FEATURE), weight);
        let smooth = kernel(&bell);
        let sum = smooth.sum();
        let feature = [
            smooth.scaled(1.0 / sum),
            kernel(&|x| x * bell(x)).balanced(),
            kernel(&|x| ((x / deviation).powi(2) - 1.0) * bell(x)).balanced(),
        ];
        let margin = radius(FEATURE).max(colour_radius);
        let most = difference(hunt([0.0, 1.0, 0.0]), hunt([0.0, 0.0, 1.0]));
        Flip { colour, feature, margin, most }
    }

    fn error_map(&self, width: usize, a: &[[f32; 3]], b: &[[f32; 3]]) -> Vec<f32> {
        let height = a.len().min(b.len()).checked_div(width).unwrap_or(0);
        let mut map = vec![0.0; width * height];
        if map.is_empty() {
            return map;
        }
        let bands = map.chunks_mut(width * BAND).enumerate();
        // The result does not depend on which thread takes which band.
        each(cores().min(height.div_ceil(BAND)), bands, |(band, out)| {
            let rows = band * BAND..band * BAND + out.len() / width;
            let [a, b] = [a, b].map(|image| self.rows(width, height, image, rows.clone()));
            for ((out, a), b) in out.chunks_mut(width).zip(&a).zip(&b) {
                self.compare(a, b, out);
            }
        });
        map
    }

    /// The filtered rows of a band.
    fn rows(&self, width: usize, height: usize, image: &[[f32; 3]], band: Range<usize>) -> Vec<FilteredRow> {
        let margin = self.margin;
        let filters: [&Filter; TERMS] = {
            let [a, rg, by, by2] = &self.colour;
            let [smooth, first, second] = &self.feature;
            [a, rg, by, by2, smooth, first, second]
        };
        let mut filtered: [Vec<Vec<f64>>; TERMS] = Default::default();
        let mut opponents: [Vec<f64>; 3] = [0, 1, 2].map(|_| vec![0.0; width + 2 * margin]);
        for y in 0..band.len() + 2 * margin {
            let y = (band.start + y).saturating_sub(margin).min(height - 1);
            for (x, colour) in image[y * width..(y + 1) * width].iter().enumerate() {
                let channels = opponent(colour.map(|v| unit(f64::from(v))));
                opponents.iter_mut().zip(channels).for_each(|(row, channel)| row[margin + x] = channel);
            }
            for row in &mut opponents {
                let (first, last) = (row[margin], row[margin + width - 1]);
                row[..margin].fill(first);
                row[margin + width..].fill(last);
            }
            for ((filter, rows), channel) in filters.iter().zip(&mut filtered).zip(CHANNEL) {
                let shifted = opponents[channel][margin - filter.radius()..].windows(width);
                rows.push(filter.weighted(shifted, width));
            }
        }
        (0..band.len()).map(|y| self.columns(width, &filtered, y + margin)).collect()
    }

    /// Filters the columns of rows that are already filtered, and returns the row `at`.
    fn columns(&self, width: usize, rows: &[Vec<Vec<f64>>; TERMS], at: usize) -> FilteredRow {
        let filtered = |kernel: &Filter, term: usize| {
            let shifted = &rows[term][at - kernel.radius()..];
            kernel.weighted(shifted.iter().map(Vec::as_slice), width)
        };
        let [a, rg, by, by2] = [0, 1, 2, 3].map(|term| filtered(&self.colour[term], term));
        let lab = (0..width).map(|x| hunt(linear([a[x], rg[x], by[x] + by2[x]]))).collect();
        let [smooth, first, second] = &self.feature;
        // A derivative along x is smoothed along y, and the reverse. The paper filters (Y + 16) / 116; the constant 16
        // does not change derivatives.
        let magnitude = |derivative: &Filter, term: usize| {
            let (along_x, along_y) = (filtered(smooth, term), filtered(derivative, 4));
            along_x.iter().zip(&along_y).map(|(x, y)| x.hypot(*y) / 116.0).collect()
        };
        FilteredRow { lab, edge: magnitude(first, 5), point: magnitude(second, 6) }
    }

    /// The error of each pixel of a row.
    fn compare(&self, a: &FilteredRow, b: &FilteredRow, out: &mut [f32]) {
        /// The start of the large colour differences, as a share of the largest, and the error there (section 4.1.3).
        const KNEE: f64 = 0.4;
        const AT_KNEE: f64 = 0.95;
        let knee = KNEE * self.most;
        for (x, out) in out.iter_mut().enumerate() {
            let colour = match difference(a.lab[x], b.lab[x]) {
                d if d < knee => d * AT_KNEE / knee,
                d => AT_KNEE + (d - knee) / (self.most - knee) * (1.0 - AT_KNEE),
            };
            // Section 4.2.2, with its exponent 1/2.
            let edge = (a.edge[x] - b.edge[x]).abs();
            let point = (a.point[x] - b.point[x]).abs();
            let feature = (edge.max(point) * std::f64::consts::FRAC_1_SQRT_2).sqrt();
            // Section 4.3. If the colours are equal, the error is 0. The feature difference can exceed 1 only by rounding.
            *out = unit(colour).powf(1.0 - feature.min(1.0)) as f32;
        }
    }
}

/// Linear Rec. 709 to CIE XYZ (IEC 61966-2-1), in fractions that make white's XYZ the sum of the columns.
const TO_XYZ: [[f64; 3]; 3] = [
    [10_135_552.0 / 24_577_794.0, 8_788_810.0 / 24_577_794.0, 4_435_075.0 / 24_577_794.0],
    [2_613_072.0 / 12_288_897.0, 8_788_810.0 / 12_288_897.0, 887_015.0 / 12_288_897.0],
    [1_425_312.0 / 73_733_382.0, 8_788_810.0 / 73_733_382.0, 70_074_185.0 / 73_733_382.0],
];

/// The inverse.
const FROM_XYZ: [[f64; 3]; 3] = [
    [3.241_003_232_976_358_7, -1.537_398_969_488_785_5, -0.498_615_881_996_362_9],
    [-0.969_224_252_202_516_6, 1.875_929_983_695_176, 0.041_554_226_340_084_724],
    [0.055_639_419_851_975_444, -0.204_011_206_123_91, 1.057_148_977_187_533_5],
];

/// XYZ relative to white.
fn relative_xyz(linear: [f64; 3]) -> [f64; 3] {
    let (xyz, white) = (product(&TO_XYZ, linear), product(&TO_XYZ, [1.0; 3]));
    [0, 1, 2].map(|i| xyz[i] / white[i])
}

/// Linear Rec. 709 to the opponent channels YyCxCz, without the constant 16 in the first channel (section 4.1.1).
fn opponent(linear: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = relative_xyz(linear);
    [116.0 * y, 500.0 * (x - y), 200.0 * (y - z)]
}

/// From opponent channels to linear Rec. 709, clamped to 0..1.
fn linear([yy, cx, cz]: [f64; 3]) -> [f64; 3] {
    let y = yy / 116.0;
    let white = product(&TO_XYZ, [1.0; 3]);
    let relative = [y + cx / 500.0, y, y - cz / 200.0];
    product(&FROM_XYZ, [0, 1, 2].map(|i| relative[i] * white[i])).map(|v| v.clamp(0.0, 1.0))
}

/// CIE L*a*b* of linear Rec. 709, with a* and b* scaled by 0.01 L*, because dark colours are less visible (section 4.1.2).
fn hunt(linear: [f64; 3]) -> [f64; 3] {
    const DELTA: f64 = 6.0 / 29.0;
    let [x, y, z] = relative_xyz(linear).map(|t| match t > DELTA * DELTA * DELTA {
        true => t.cbrt(),
        false => t / (3.0 * DELTA * DELTA) + 4.0 / 29.0,
    });
    let lightness = 116.0 * y - 16.0;
    [lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)]
}

/// The HyAB distance to the power of 0.7 (section 4.1.3).
fn difference(a: [f64; 3], b: [f64; 3]) -> f64 {
    ((a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])).powf(0.7)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pseudo-random 0 ≤ u < 1 from mixed bits.
    fn u(x: u32, y: u32, c: u32) -> f64 {
        let mut h = x.wrapping_mul(73_856_093) ^ y.wrapping_mul(19_349_663) ^ c.wrapping_mul(83_492_791);
        h = h.wrapping_mul(2_654_435_761);
        h = (h ^ h >> 15).wrapping_mul(2_246_822_519);
        f64::from(h ^ h >> 13) / 4_294_967_296.0
    }

    type Formula = fn(u32, u32, u32) -> f64;

    /// A name, the size, two images, and FLIP's mean at 67.02 and at 40 pixels per degree.
    type Case = (&'static str, (u32, u32), Formula, Formula, [f64; 2]);

    /// Image pairs with the results of the authors' program: the Python package flip-evaluator 1.7, `evaluate(b, a,
    /// "LDR")` of both images clamped to 0..1 and sRGB-encoded, in f32.
    fn cases() -> Vec<Case> {
        fn is(condition: bool) -> f64 {
            f64::from(u8::from(condition))
        }
        vec![
            ("greys", (16, 12), |_, _, _| 0.2, |_, _, _| 0.25, [0.183_409_259, 0.183_414_042]),
            (
                "one pixel",
                (1, 1),
                |_, _, c| [0.8, 0.1, 0.1][c as usize],
                |_, _, c| [0.1, 0.7, 0.2][c as usize],
                [0.966_336_131, 0.966_338_754],
            ),
            (
                "smaller than the kernels",
                (5, 3),
                |x, y, c| f64::from(x + 2 * y + c) / 12.0,
                u,
                [0.637_499_511, 0.628_626_227],
            ),
            (
                "an edge one pixel on",
                (64, 48),
                |x, _, _| 0.1 + 0.8 * is(x < 30),
                |x, _, _| 0.1 + 0.8 * is(x < 31),
                [0.036_943_890, 0.030_516_259],
            ),
            (
                "one bright pixel",
                (33, 47),
                |_, _, _| 0.18,
                |x, y, _| 0.18 + 0.82 * is((x, y) == (16, 20)),
                [0.003_057_978, 0.002_217_335],
            ),
            (
                "a gradient with noise",
                (60, 40),
                |x, y, _| f64::from(x + y) / 100.0,
                |x, y, c| f64::from(x + y) / 100.0 + 0.2 * (u(x, y, c) - 0.5),
                [0.108_580_463, 0.160_722_345],
            ),
            ("a row", (128, 1), |x, y, c| u(x / 4, y, c), |x, y, c| u(x / 4, y, c + 3), [0.822_098_672, 0.852_280_200]),
            (
                "a checker and its grey",
                (31, 31),
                |x, y, _| is((x + y) % 2 == 1),
                |_, _, _| 0.5,
                [0.011_324_214, 0.141_627_967],
            ),
            (
                "green and blue",
                (40, 30),
                |x, _, c| is(c == if x < 25 { 1 } else { 2 }),
                |_, y, c| is(c == if y < 9 { 2 } else { 1 }),
                [0.654_371_977, 0.582_783_759],
            ),
            (
                "beyond black and white",
                (50, 37),
                |x, y, c| 0.5 + 1.2 * (0.31 * f64::from(x) + f64::from(c)).sin() * (0.17 * f64::from(y)).cos(),
                |x, y, c| 0.5 + 1.1 * (0.31 * f64::from(x) + f64::from(c) + 0.1).sin() * (0.18 * f64::from(y)).cos(),
                [0.337_636_650, 0.365_356_445],
            ),
        ]
    }

    fn image((width, height): (u32, u32), formula: Formula) -> Vec<[f32; 3]> {
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        pixels.map(|(x, y)| [0, 1, 2].map(|c| formula(x, y, c) as f32)).collect()
    }

    fn judge(flip: &Flip, &(_, size, a, b, _): &Case) -> f64 {
        mean(&flip.error_map(size.0 as usize, &image(size, a), &image(size, b)))
    }

    const TOLERANCE: f64 = 1e-4;

    #[test]
    fn flip_agrees_with_the_program_of_its_authors() {
        for case in cases() {
            let found = [PIXELS_PER_DEGREE, 40.0].map(|density| judge(&Flip::new(density), &case));
            let (name, .., expected) = case;
            for (found, expected) in found.into_iter().zip(expected) {
                println!("{name}: {found:.6}, theirs {expected:.6}, off by {:.1e}", found - expected);
                assert!((found - expected).abs() < TOLERANCE, "{name}: {found}, expected {expected}");
            }
        }
    }

    /// Negative control: the test detects another density, and a FLIP without edges or without points.
    #[test]
    fn a_wrong_flip_is_found() {
        let found = |wrong: &Flip| cases().iter().filter(|c| (judge(wrong, c) - c.4[0]).abs() > TOLERANCE).count();
        assert_eq!(found(&Flip::new(PIXELS_PER_DEGREE)), 0);
        // Uniform images and single pixels give the same result at any density.
        assert!(found(&Flip::new(PIXELS_PER_DEGREE * 1.05)) >= 7);
        for derivative in [1, 2] {
            let mut blind = Flip::new(PIXELS_PER_DEGREE);
            blind.feature[derivative].0.fill(0.0);
            assert!(found(&blind) >= 3, "{derivative}: {}", found(&blind));
        }
        let mut blind = Flip::new(PIXELS_PER_DEGREE);
        blind.colour[3].0.fill(0.0);
        assert!(found(&blind) >= 3);
    }

    #[test]
    fn flip_is_symmetric_and_zero_for_equal_images() {
        let (_, size, a, b, _) = cases()[9];
        let (a, b) = (image(size, a), image(size, b));
        assert_eq!(error_map(50, &a, &b), error_map(50, &b, &a));
        assert_eq!(mean(&error_map(50, &a, &a)), 0.0);
        let (nan, black) = (vec![[f32::NAN; 3]; 6], vec![[0.0; 3]; 6]);
        assert_eq!(error_map(3, &nan, &black), [0.0; 6]);
        assert!(error_map(0, &[], &[]).is_empty() && error_map(5, &[], &[]).is_empty());
    }

    /// There is no seam between bands: the map of a periodic image of several bands is periodic.
    #[test]
    fn an_image_in_bands_has_the_errors_of_one_in_one_band() {
        let height = 3 * BAND + 5;
        let column =
            |shift: f64| (0..height).map(|y| [(0.5 + 0.4 * (y as f64 * 0.7 + shift).sin()) as f32; 3]).collect();
        let (a, b): (Vec<[f32; 3]>, Vec<[f32; 3]>) = (column(0.0), column(0.3));
        let upright = error_map(1, &a, &b);
        // The transposed image is one band.
        let lying = error_map(height, &a, &b);
        assert!(upright.iter().zip(&lying).all(|(a, b)| (a - b).abs() < 1e-6));
    }
}

//! The referee of the film on the device: runs and splats added one by one on the host, in integers of 128 bits.

use gpu_rt::data::{ODD_RUN, PixelTotals, Rgb, RunRecord, SPLAT_SUMS, SQUARE_FRACTION, SUM_FRACTION};
use gpu_rt::film::{Film, Rejected, Totals};

/// A finished run, as the film gets it, by channels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Run {
    /// The sum of the accepted samples' radiance.
    pub sum: Rgb<f32>,
    pub pixel: u32,
    /// Accepted samples | rejected as NaN << 8 | rejected as infinite << 16 | rejected as cut short << 24 | [`ODD_RUN`].
    pub counts: u32,
    pub rays: u32,
    /// The squared deviations of the accepted samples from their mean, summed.
    pub squared_deviations: Rgb<f32>,
}

impl Run {
    /// As the device has it.
    pub fn record(&self) -> RunRecord {
        let Run {
            sum: [sum_r, sum_g, sum_b],
            pixel,
            counts,
            rays,
            squared_deviations: [squares_r, squares_g, squares_b],
        } = *self;
        RunRecord { sum_r, sum_g, sum_b, pixel, counts, rays, squares_r, squares_g, squares_b }
    }

    /// What it adds to its pixel and to the film's counts. Where samples have weights of either sign, so may their sum.
    fn totals(&self, signed: bool) -> (PixelTotals, Totals) {
        let [accepted, nan, infinite, cut] = (self.counts & !ODD_RUN).to_le_bytes();
        let mut rejected =
            Rejected { nan: u64::from(nan), infinite: u64::from(infinite), cut: u64::from(cut), refused: 0 };
        let paths = u64::from(accepted) + rejected.total();
        let mut pixel = PixelTotals::default();
        let unsigned = self.sum.map(|value| if signed { value.abs() } else { value });
        // A NaN fails this too.
        if !unsigned.iter().chain(&self.squared_deviations).all(|value| *value >= 0.0) {
            rejected.refused += u64::from(accepted);
        } else if unsigned.iter().any(|value| value.is_infinite()) {
            rejected.infinite += u64::from(accepted);
        } else if accepted > 0 {
            let half = usize::from(self.counts & ODD_RUN != 0);
            for channel in 0..3 {
                let values = [
                    (3 * half + channel, self.sum[channel], SUM_FRACTION),
                    (6 + channel, self.squared_deviations[channel], SQUARE_FRACTION),
                ];
                for (sum, value, fraction) in values {
                    match to_fixed(f64::from(value), fraction as i32) {
                        Some(fixed) => pixel.sums[sum] = [0, 32, 64, 96].map(|shift| (fixed >> shift) as u32),
                        None => pixel.saturated |= 1 << sum,
                    }
                }
            }
            pixel.samples[half] = u32::from(accepted);
            pixel.runs = 1;
        }
        pixel.rejected = rejected.total() as u32;
        (pixel, Totals { paths, rays: u64::from(self.rays), rejected, ..Totals::default() })
    }
}

/// What a light path adds to a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Splat {
    pub pixel: u32,
    pub value: Rgb<f32>,
    /// Whether its run is an odd one.
    pub odd: bool,
}

impl Splat {
    /// What it adds to its pixel, as the film of a device without channels of `--aov` has it.
    fn bytes(&self) -> Vec<u8> {
        let mut totals = PixelTotals::default();
        let mut sums = [0; SPLAT_SUMS];
        let first = totals.sums.len();
        for channel in 0..3 {
            let value = self.value[channel];
            let values = [
                (3 * usize::from(self.odd) + channel, value, SUM_FRACTION),
                (6 + channel, value * value, SQUARE_FRACTION),
            ];
            for (sum, value, fraction) in values {
                match to_fixed(f64::from(value), fraction as i32) {
                    Some(fixed) => sums[sum] = fixed,
                    None => totals.saturated |= 1 << (first + sum).min(31),
                }
            }
        }
        let sums = sums.into_iter().flat_map(i128::to_le_bytes);
        bytemuck::bytes_of(&totals).iter().copied().chain(sums).collect()
    }
}

/// `value` in units of 2^-fraction, rounded to the nearest (halves away from 0); nothing where 127 bits and a sign do not hold it.
pub fn to_fixed(value: f64, fraction: i32) -> Option<i128> {
    // value = mantissa * 2^(exponent - 1075) (IEEE 754-2019, section 3.4). Denormals, below 2^-1022, round to 0 here anyway.
    let bits = value.to_bits();
    let exponent = (bits >> 52 & 0x7ff) as i32;
    let mantissa = i128::from(bits & ((1 << 52) - 1) | 1 << 52);
    let fixed = match exponent - 1075 + fraction {
        // The mantissa has 53 bits.
        75.. => return None,
        shift @ 0..75 => mantissa << shift,
        shift @ -53..0 => (mantissa + (1 << (-shift - 1))) >> -shift,
        _ => 0,
    };
    Some(if value < 0.0 { -fixed } else { fixed })
}

/// Adds runs to a film, one by one.
pub trait AddRuns {
    fn add_runs(&mut self, runs: &[Run]);

    /// Adds runs of samples that have weights of either sign.
    fn add_signed_runs(&mut self, runs: &[Run]);

    /// Adds splats to a film with light paths and without channels of `--aov`.
    fn add_splats(&mut self, splats: &[Splat]);
}

impl AddRuns for Film {
    fn add_runs(&mut self, runs: &[Run]) {
        add(self, runs, false);
    }

    fn add_signed_runs(&mut self, runs: &[Run]) {
        add(self, runs, true);
    }

    fn add_splats(&mut self, splats: &[Splat]) {
        splats.iter().for_each(|splat| self.add_from_device([splat.pixel as usize], &splat.bytes(), None));
    }
}

fn add(film: &mut Film, runs: &[Run], signed: bool) {
    for run in runs {
        let (pixel, counted) = run.totals(signed);
        film.add([(run.pixel as usize, &pixel)], counted);
    }
}

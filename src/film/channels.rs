//! The exact sums of a pixel that not every film has: those of the channels of `--aov`, and those of the splats of light paths.

use std::mem::size_of;
use std::ops::Range;

use glam::DVec3;

use super::floats::exp2;
use crate::aov::{Aov, Aovs, SceneSpace, Sum, sums_of_group};
use crate::data::{CHANNELS, FILM_SUMS, PixelTotals, Rgb, RunRecord, SPLAT_SUMS, SUM_FRACTION};
use crate::error::{Error, Result};
use crate::memory;

/// The words that the film has of a motion, by those that kernels store (`crate::flatten::Neighbours::motion`).
pub type MotionOf<'a> = &'a dyn Fn([u32; 6]) -> [u32; 4];

/// The sums of all pixels.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Channels {
    pub aovs: Aovs,
    pub space: SceneSpace,
    /// Whether the sums of splats follow those of `--aov`.
    pub light_paths: bool,
    /// The number of sums of a pixel.
    pub count: usize,
    /// The sums of each pixel, one pixel after the other, in units of 2^-[`SUM_FRACTION`], but for the squares of splats; `i128::MAX` for a sum
    /// that has left its range.
    sums: Vec<i128>,
    /// The number of words of sample 0 of a pixel.
    pub words: usize,
    /// These words of each pixel, one pixel after the other; 0 where there is none.
    stored: Vec<u32>,
}

/// The sums of the splats that light paths have added to a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Splats {
    /// Of light paths of even and of odd runs, in units of 2^-[`SUM_FRACTION`].
    pub halves: [Rgb<i128>; 2],
    /// The squares of the splats, in units of 2^-[`crate::data::SQUARE_FRACTION`].
    pub squares: Rgb<i128>,
}

impl Splats {
    /// The splats of a pixel whose last sums are theirs.
    pub fn of_sums(sums: &[i128]) -> Splats {
        match sums.last_chunk::<SPLAT_SUMS>() {
            Some([a, b, c, d, e, f, squares @ ..]) => {
                Splats { halves: [[*a, *b, *c], [*d, *e, *f]], squares: *squares }
            }
            None => Splats::default(),
        }
    }
}

/// Bytes of a pixel of the device's film.
pub fn device_bytes(aovs: &Aovs, light_paths: bool) -> u64 {
    // Behind the words of sample 0, one says which groups of lights have left their range; then come mattes.
    let of_groups = usize::from(!aovs.groups().is_empty());
    let words = aovs.words_of_kernels().len() + of_groups + aovs.matte_words();
    (size_of::<PixelTotals>() + count(aovs, light_paths) * size_of::<[u32; 4]>() + words * size_of::<u32>()) as u64
}

/// Bytes of a finished run's record.
pub fn record_bytes(aovs: &Aovs) -> u64 {
    (size_of::<RunRecord>() + aovs.count() * size_of::<f32>()) as u64
}

/// The number of sums of a pixel behind those of every film.
pub(super) fn count(aovs: &Aovs, light_paths: bool) -> usize {
    aovs.count_on_film(light_paths) + if light_paths { SPLAT_SUMS } else { 0 }
}

/// The names of these sums, in their order.
pub(super) fn names(aovs: &Aovs, light_paths: bool) -> impl Iterator<Item = String> {
    let splats = ["light_even", "light_odd", "light_squares"].into_iter().filter(move |_| light_paths);
    aovs.names_on_film(light_paths).chain(splats.flat_map(|name| CHANNELS.map(|channel| format!("{name}.{channel}"))))
}

/// Whether a sum of a pixel has left its range on the device. Sums from the last bit on share it.
pub(super) fn has_saturated(totals: &PixelTotals, sum: usize) -> bool {
    totals.saturated >> sum.min(31) & 1 == 1
}

/// One film has sample 0 of a pixel, and the others have zeros.
fn keep_words(mine: &mut [u32], theirs: &[u32]) {
    mine.iter_mut().zip(theirs).for_each(|(mine, theirs)| *mine |= theirs);
}

impl Channels {
    pub fn new(pixels: usize, aovs: &Aovs, space: SceneSpace, light_paths: bool) -> Result<Channels> {
        let count = count(aovs, light_paths);
        let all = pixels.saturating_mul(count);
        let needs = |memory: String| {
            Error::Usage(match (aovs.is_empty(), light_paths) {
                (false, true) => {
                    format!(
                        "the channels of --aov and --light-paths need {memory}; ask for fewer, or for --light-paths off"
                    )
                }
                (false, false) => format!("the channels of --aov need {memory}; ask for fewer"),
                (true, _) => format!("the film of --light-paths needs {memory} more; use --light-paths off"),
            })
        };
        let words = aovs.words_on_film().len();
        let all_words = pixels.saturating_mul(words);
        if all > 0 || all_words > 0 {
            let bytes =
                all.saturating_mul(size_of::<i128>()).saturating_add(all_words.saturating_mul(size_of::<u32>()));
            memory::check(bytes as u64).map_err(needs)?;
        }
        let cannot = |_| needs("more memory than can be had".to_string());
        let sums = bytemuck::allocation::try_zeroed_vec::<i128>(all).map_err(cannot)?;
        let stored = bytemuck::allocation::try_zeroed_vec::<u32>(all_words).map_err(cannot)?;
        let space = if aovs.is_empty() { SceneSpace::default() } else { space };
        Ok(Channels { aovs: aovs.of_film(), space, light_paths, count, sums, words, stored })
    }

    pub fn clear(&mut self) {
        self.sums.fill(0);
        self.stored.fill(0);
    }

    pub fn add(&mut self, other: &Channels) {
        self.sums.iter_mut().zip(&other.sums).for_each(|(mine, theirs)| *mine = mine.saturating_add(*theirs));
        keep_words(&mut self.stored, &other.stored);
    }

    /// Adds the sums of a pixel from a device, where they follow its totals, and keeps the words of sample 0 behind them.
    pub fn add_from_device(&mut self, index: usize, totals: &PixelTotals, rest: &[u8], motion: Option<MotionOf<'_>>) {
        let (sums, words) = rest.split_at(self.count * size_of::<[u32; 4]>());
        let mut words: Vec<u32> = words.chunks_exact(size_of::<u32>()).map(bytemuck::pod_read_unaligned).collect();
        let (groups, each) = (self.groups(), sums_of_group(self.light_paths));
        let saturated_groups = if groups.is_empty() { 0 } else { words.pop().unwrap_or_default() };
        match words.split_first_chunk() {
            Some((seen, others)) if self.aovs.has(Aov::Motion) => {
                let motion = motion.map_or([0; 4], |motion| motion(*seen));
                self.keep_words(index, &[&motion, others].concat());
            }
            _ => self.keep_words(index, &words),
        }
        let Some(mine) = self.of_mut(index) else { return };
        for (number, (mine, words)) in mine.iter_mut().zip(sums.chunks_exact(size_of::<[u32; 4]>())).enumerate() {
            let words: [u32; 4] = bytemuck::pod_read_unaligned(words);
            let is_saturated = match groups.contains(&number) {
                true => saturated_groups >> ((number - groups.start) / each) & 1 == 1,
                false => has_saturated(totals, FILM_SUMS + number),
            };
            let sum = match is_saturated {
                false => i128::from_le_bytes(bytemuck::cast(words.map(u32::to_le))),
                true => i128::MAX,
            };
            *mine = mine.saturating_add(sum);
        }
    }

    /// The words of sample 0 of a pixel; empty if the film has none.
    pub fn words_of_pixel(&self, index: usize) -> &[u32] {
        self.stored.get(index * self.words..(index + 1) * self.words).unwrap_or_default()
    }

    /// Takes the words of sample 0 of a pixel, unless there are some.
    pub fn keep_words(&mut self, index: usize, words: &[u32]) {
        if let Some(mine) = self.stored.get_mut(index * words.len()..(index + 1) * words.len()) {
            keep_words(mine, words);
        }
    }

    /// The sums of a pixel; empty if the pixel is not in the image.
    pub fn sums_of_pixel(&self, index: usize) -> &[i128] {
        self.sums.get(index * self.count..(index + 1) * self.count).unwrap_or_default()
    }

    pub fn of_mut(&mut self, index: usize) -> Option<&mut [i128]> {
        self.sums.get_mut(index * self.count..(index + 1) * self.count)
    }

    /// The indices of the sums of groups of lights.
    fn groups(&self) -> Range<usize> {
        self.aovs.plain_count()..self.aovs.count_on_film(self.light_paths)
    }

    /// The sums of a group of lights of a pixel: of even and of odd runs, and of their light paths. `None` if one has left its range.
    pub fn light(&self, index: usize, group: usize) -> Option<[Rgb<i128>; 4]> {
        let each = sums_of_group(self.light_paths);
        let first = self.groups().start + group * each;
        let sums = self.sums_of_pixel(index).get(first..first + each)?;
        let mut light = [[0; 3]; 4];
        light.iter_mut().flatten().zip(sums).for_each(|(light, sum)| *light = *sum);
        (!sums.contains(&i128::MAX)).then_some(light)
    }

    /// The splats of a pixel; none if the film has no light paths.
    pub fn splats(&self, index: usize) -> Splats {
        if self.light_paths { Splats::of_sums(self.sums_of_pixel(index)) } else { Splats::default() }
    }

    /// A component of a sum; 0 if the film lacks it, and `None` if it has left its range.
    pub fn sum(&self, index: usize, sum: Sum, component: usize) -> Option<f64> {
        let sum_index = self.aovs.first_sum(sum).map_or(usize::MAX, |first| first + component);
        match self.sums_of_pixel(index).get(sum_index).copied().unwrap_or(0) {
            i128::MAX => None,
            sum => Some(sum as f64 * exp2(-(SUM_FRACTION as i32))),
        }
    }

    /// The three components divided by a count; 0 if the count is 0.
    pub fn mean(&self, index: usize, sum: Sum, count: f64) -> Option<DVec3> {
        let component = |component| self.sum(index, sum, component);
        let sums = DVec3::new(component(0)?, component(1)?, component(2)?);
        Some(if count == 0.0 { DVec3::ZERO } else { sums / count })
    }
}

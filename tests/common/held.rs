//! How often the bound of an image's error holds: over many seeds, against the mean of all the others.

use gpu_rt::film::ErrorEstimate;
use gpu_rt::render::{NOISE_LEVEL, level_after};
use gpu_rt::scene::Scene;

use super::render::{Change, Request, render_with};

/// A floor under a quad lamp, and a bulb smaller than a pixel: two pixels hold nearly all of the noise.
pub const BULB: &str = "Scene(
    image: (width: 16, height: 16),
    camera: (look_from: (0, 2, 5), look_at: (0, 0.3, 0), vertical_fov: 40),
    background: Solid((0, 0, 0)),
    materials: {
        \"floor\": Lambertian(albedo: Rgb(0.6, 0.6, 0.6)),
        \"lamp\": DiffuseLight(emit: Rgb(5, 5, 5), two_sided: false),
        \"bulb\": DiffuseLight(emit: Rgb(40, 40, 40)),
    },
    objects: [
        Quad(corner: (-4, 0, 4), u: (8, 0, 0), v: (0, 0, -8), material: \"floor\"),
        Quad(corner: (-1, 3, -1), u: (2, 0, 0), v: (0, 0, 2), material: \"lamp\"),
        Sphere(center: (0.5, 0.4, 0.3), radius: 0.03, material: \"bulb\"),
    ],
    render: (samples: 16, max_depth: 8),
)";

/// One seed's image after so many samples.
struct Replicate {
    image: Vec<[f64; 3]>,
    error: ErrorEstimate,
    /// Its bound at the level that `--noise` has left at this check.
    bound_of_check: f64,
}

/// Images of many seeds, each after so many samples.
pub struct Replicates {
    samples: Vec<u32>,
    seeds: Vec<Vec<Replicate>>,
}

/// Of the seeds of one number of samples.
#[derive(Clone, Copy, Debug)]
pub struct Held {
    pub samples: u32,
    pub seeds: usize,
    /// The share of images whose error is below its bound, and of those that are called reliable.
    pub share: f64,
    pub reliable: f64,
    pub share_of_reliable: f64,
    /// The median of bound over error.
    pub width: f64,
}

impl std::fmt::Display for Held {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Held { samples, seeds, share, reliable, share_of_reliable, width } = self;
        write!(
            f,
            "{samples} samples, {seeds} seeds: held by {share:.3}, bound/error {width:.2}; {reliable:.3} reliable, of these {share_of_reliable:.3}"
        )
    }
}

impl Held {
    /// Whether nine of ten bounds hold, and as many of those that are called reliable, if a tenth of the images is.
    pub fn holds(&self) -> bool {
        self.share >= 0.9 && (self.reliable < 0.1 || self.share_of_reliable >= 0.9)
    }
}

impl Replicates {
    /// Renders; the numbers of samples rise.
    pub fn new(scene: &Scene, request: &Request, change: &Change<'_>, seeds: u32, samples: &[u32]) -> Replicates {
        let starts = std::iter::once(&0).chain(samples);
        let ranges: Vec<_> = starts.zip(samples).map(|(start, end)| *start..*end).collect();
        let wanted = (0..seeds).flat_map(|seed| ranges.iter().map(move |range| (seed, range.clone())));
        let (mut all, mut of_seed, mut film) = (Vec::new(), Vec::new(), None);
        render_with(scene, request, wanted, change, |shot| {
            let so_far = match film.take() {
                Some(mut before) => {
                    gpu_rt::film::Film::merge(&mut before, &shot.film).expect("films of one image");
                    before
                }
                None => shot.film,
            };
            // A film that knows the lamps in view knows their error by their size, which would hide a planted one.
            let so_far = if change.library.is_some() { so_far.with_lamps(&[]) } else { so_far };
            let level = level_after(of_seed.len() as u32);
            of_seed.push(Replicate {
                image: so_far.develop().rgb.iter().map(|rgb| rgb.map(f64::from)).collect(),
                error: so_far.error_estimate(NOISE_LEVEL).expect("there is light"),
                bound_of_check: so_far.error_estimate(level).expect("there is light").bound,
            });
            match of_seed.len() == samples.len() {
                true => all.push(std::mem::take(&mut of_seed)),
                false => film = Some(so_far),
            }
        });
        Replicates { samples: samples.to_vec(), seeds: all }
    }

    /// The true errors: of each seed, after each number of samples. What an image is compared with are the last images of all other seeds.
    fn truths(&self) -> Vec<Vec<f64>> {
        let last = |images: &Vec<Replicate>| images.last().expect("one at least").image.clone();
        let images: Vec<Vec<[f64; 3]>> = self.seeds.iter().map(last).collect();
        let pixels = images[0].len();
        let sum: Vec<[f64; 3]> =
            (0..pixels).map(|p| [0, 1, 2].map(|c| images.iter().map(|image| image[p][c]).sum())).collect();
        let others = images.len() as f64 - 1.0;
        let luminance = |rgb: &[f64; 3]| 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
        let of_seed = |(images, own): (&Vec<Replicate>, &Vec<[f64; 3]>)| {
            let reference: Vec<[f64; 3]> =
                (0..pixels).map(|p| [0, 1, 2].map(|c| (sum[p][c] - own[p][c]) / others)).collect();
            let floor = 0.01 * (reference.iter().map(luminance).sum::<f64>() / pixels as f64).powi(2);
            let error = |replicate: &Replicate| {
                let pairs = replicate.image.as_flattened().iter().zip(reference.as_flattened());
                (pairs.map(|(i, r)| (i - r).powi(2) / (r * r + floor)).sum::<f64>() / (3 * pixels) as f64).sqrt()
            };
            images.iter().map(error).collect()
        };
        self.seeds.iter().zip(&images).map(of_seed).collect()
    }

    /// The errors that all images state.
    pub fn errors(&self) -> impl Iterator<Item = &ErrorEstimate> {
        self.seeds.iter().flatten().map(|replicate| &replicate.error)
    }

    /// The share of images whose error is below another figure of theirs, by the number of samples.
    pub fn held_by(&self, figure: impl Fn(&ErrorEstimate) -> f64) -> Vec<f64> {
        let truths = self.truths();
        let held = |k: usize| {
            let count =
                self.seeds.iter().zip(&truths).filter(|(images, truths)| truths[k] <= figure(&images[k].error)).count();
            count as f64 / self.seeds.len() as f64
        };
        (0..self.samples.len()).map(held).collect()
    }

    /// How often the bound holds, by the number of samples.
    pub fn held(&self) -> Vec<Held> {
        let truths = self.truths();
        let share = |of: &[bool]| of.iter().filter(|held| **held).count() as f64 / of.len() as f64;
        let of_samples = |(k, samples): (usize, &u32)| {
            let images = self.seeds.iter().zip(&truths).map(|(images, truths)| (&images[k].error, truths[k]));
            let held: Vec<(bool, bool)> =
                images.clone().map(|(error, truth)| (truth <= error.bound, error.reliable)).collect();
            let reliable: Vec<bool> = held.iter().filter(|(_, reliable)| *reliable).map(|(held, _)| *held).collect();
            let mut widths: Vec<f64> = images.map(|(error, truth)| error.bound / truth).collect();
            widths.sort_by(f64::total_cmp);
            Held {
                samples: *samples,
                seeds: held.len(),
                share: share(&held.iter().map(|(held, _)| *held).collect::<Vec<_>>()),
                reliable: reliable.len() as f64 / held.len() as f64,
                share_of_reliable: share(&reliable),
                width: widths[widths.len() / 2],
            }
        };
        self.samples.iter().enumerate().map(of_samples).collect()
    }

    /// The share of seeds for which `--noise error`, which checks the error at these numbers of samples, ends with a larger error; and the share that it
    /// ends for.
    pub fn noise_is_wrong(&self, error: f64) -> (f64, f64) {
        let (mut wrong, mut ended) = (0, 0);
        for (images, truths) in self.seeds.iter().zip(self.truths()) {
            if let Some(k) = images.iter().position(|replicate| replicate.bound_of_check < error) {
                ended += 1;
                wrong += usize::from(truths[k] > error);
            }
        }
        let share = |count: usize| count as f64 / self.seeds.len() as f64;
        (share(wrong), share(ended))
    }
}

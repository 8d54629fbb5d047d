//! shaders/step/film.wgsl: the film on the device holds what exact addition on the host gives, to the bit.

use gpu_rt::data::{Counters, ODD_RUN, PATHS, PixelTotals, RAYS, RunRecord};
use gpu_rt::film::{Film, Rejected, Totals, UNKNOWN_VARIANCE};
use gpu_rt::gpu::buffers::BufferSpec;

use crate::common::film::{AddRuns, Run};
use crate::common::kernel::{Kernel, Plant, Setup};
use crate::common::stats::Random;

const PIXELS: u32 = 5;

/// Words that do not carry, and words that do not borrow.
const CARRIES_NOT: Plant = ("lib/carry", "select(0u, 1u, before + added < before)", "0u");
const BORROWS_NOT: Plant = ("lib/carry", "select(0u, 1u, before < taken)", "0u");

/// Adds runs to an empty film on the device, with what is planted.
fn on_device(plants: &[Plant], records: &[Run]) -> Film {
    linked_with(plants, false, records)
}

/// Adds runs whose filter has negative lobes or not.
fn linked_with(plants: &[Plant], has_negative_lobes: bool, records: &[Run]) -> Film {
    let run_length = gpu_rt::data::RUN_LENGTH.to_string();
    let facts = &[("filter.mitchell", has_negative_lobes), ("filter.box", !has_negative_lobes)];
    let setup = Setup { plants, values: &[("run_length", &run_length), ("film_sums", "9")], facts, ..Setup::default() };
    let kernel = Kernel::with("test/film", &setup).planted(0);
    let buffers = [
        BufferSpec::working("film", u64::from(PIXELS) * size_of::<PixelTotals>() as u64, "the test"),
        BufferSpec::working("counters", size_of::<Counters>() as u64, "the test"),
    ];
    let rows: Vec<RunRecord> = records.iter().map(Run::record).collect();
    let read = |buffer, count| kernel.run_for::<_, u32>(&rows, rows.len(), &buffers, (buffer, count));
    let words = read("film", PIXELS as usize * size_of::<PixelTotals>() / 4);
    let totals: Vec<PixelTotals> = bytemuck::pod_collect_to_vec(&words);
    // A second time, for the counters.
    let words = read("counters", size_of::<Counters>() / 4);
    let counters: Vec<Counters> = bytemuck::pod_collect_to_vec(&words);
    let Counters { nan, infinite, cut, refused, counts, .. } = counters[0];
    let count = |which: u32| u64::from(counts[which as usize][1]) << 32 | u64::from(counts[which as usize][0]);
    let [nan, infinite, cut, refused] = [nan, infinite, cut, refused].map(u64::from);
    let counted = Totals {
        paths: count(PATHS),
        rays: count(RAYS),
        rejected: Rejected { nan, infinite, cut, refused },
        ..Totals::default()
    };
    let mut film = Film::new(PIXELS, 1, 0).expect("a few pixels fit");
    film.add((0..).zip(&totals), counted);
    film
}

fn on_host(records: &[Run]) -> Film {
    let mut film = Film::new(PIXELS, 1, 0).expect("a few pixels fit");
    film.add_runs(records);
    film
}

/// Values that a sum can have, and some that none has: of all exponents, at every edge of the fixed point, and no numbers.
fn value(random: &mut Random) -> f32 {
    const EDGES: [u32; 14] = [
        0,
        0x8000_0000, // -0
        1,           // subnormal numbers
        0x007f_ffff,
        0x0080_0000,
        (127 - 89) << 23, // half a unit of the sums
        ((127 - 89) << 23) - 1,
        (127 - 97) << 23, // half a unit of the squares
        (127 + 38) << 23, // the largest powers of two that fit
        (127 + 30) << 23,
        (127 + 39) << 23, // and the least ones that do not
        (127 + 31) << 23,
        0x7f7f_ffff,
        0x3f80_0000,
    ];
    match random.below(40) {
        0 => f32::NAN,
        1 => f32::INFINITY,
        2 => -1e-30,
        3 => f32::NEG_INFINITY,
        4..20 => f32::from_bits(EDGES[random.below(EDGES.len())]),
        // Of the exponents that are near those of the fixed point.
        20..30 => f32::from_bits(random.below(0x7f80_0000) as u32),
        _ => f32::from_bits((random.below(140 << 23) + (25 << 23)) as u32),
    }
}

fn runs(count: usize, values: &mut dyn FnMut() -> f32, random: &mut Random) -> Vec<Run> {
    (0..count)
        .map(|_| {
            let [accepted, nan, infinite, cut] = [6, 2, 2, 2].map(|below| random.below(below) as u32);
            let parity = if random.below(2) == 1 { ODD_RUN } else { 0 };
            Run {
                sum: [values(), values(), values()],
                pixel: random.below(PIXELS as usize) as u32,
                counts: accepted | nan << 8 | infinite << 16 | cut << 24 | parity,
                // So many that their sum exceeds 32 bits.
                rays: random.below(1 << 24) as u32,
                squared_deviations: [values(), values(), values()],
            }
        })
        .collect()
}

#[test]
fn the_device_adds_as_exactly_as_the_host() {
    let mut random = Random(1);
    // Few runs of each pixel, so that not all saturate; then many, which carry again and again.
    for (seed, count) in [(2, 3), (3, 10), (4, 40), (5, 20_000)] {
        let mut values = Random(seed);
        let records = runs(count, &mut || value(&mut values), &mut random);
        assert!(on_device(&[], &records) == on_host(&records), "{count} runs");
    }
    let mut values = Random(6);
    let mut common = || (10f64.powf(12.0 * values.uniform() - 8.0)) as f32;
    let records = runs(50_000, &mut common, &mut random);
    let (device, host) = (on_device(&[], &records), on_host(&records));
    assert!(device == host);
    assert_eq!(device.totals, host.totals);
    assert!(device.totals.rays > 1 << 32 && device.relative_error().is_some());
    // A film whose words do not carry is found.
    assert!(on_device(&[CARRIES_NOT], &records) != host);
}

/// Sums of either sign that stay in their range; each value saturates by itself where it is too large.
#[test]
fn the_device_adds_either_sign_as_exactly_as_the_host() {
    let mut random = Random(7);
    let mut values = Random(8);
    let mut either = || {
        let size = (10f64.powf(20.0 * values.uniform() - 12.0)) as f32;
        if values.below(2) == 1 { -size } else { size }
    };
    let mut records = runs(50_000, &mut either, &mut random);
    records.iter_mut().for_each(|run| run.squared_deviations = [1e-3; 3]);
    let on_host = |records: &[Run]| {
        let mut film = Film::new(PIXELS, 1, 0).expect("a few pixels fit");
        film.add_signed_runs(records);
        film
    };
    let on_device = |plants: &[Plant], records: &[Run]| linked_with(plants, true, records);
    let host = on_host(&records);
    assert!(on_device(&[], &records) == host);
    assert_eq!(host.totals.rejected.refused, 0);
    let picture = host.develop();
    assert!(picture.variance.iter().all(|variance| variance[0] < UNKNOWN_VARIANCE));
    assert!(picture.rgb.as_flattened().iter().any(|value| *value < 0.0));
    // Order does not matter, and what is added and taken away again is not there.
    random.shuffle(&mut records);
    assert!(on_device(&[], &records) == host);
    let opposite = records.iter().map(|run| Run { sum: run.sum.map(|value| -value), ..*run });
    let nothing = on_device(&[], &records.iter().copied().chain(opposite).collect::<Vec<_>>()).develop();
    assert_eq!(nothing.rgb, [[0.0; 3]; PIXELS as usize]);
    // Edges, few of them in a pixel, so that their sum stays in range; NaN and infinity.
    let edges =
        [-2f32.powi(38), 2f32.powi(39), -2f32.powi(39), -1e-30, f32::NAN, f32::NEG_INFINITY, -0.0, -2f32.powi(-89)];
    for value in edges {
        let run = Run { sum: [1.0, value, 1.0], squared_deviations: [1.0; 3], counts: 4, ..Run::default() };
        let records = [run, Run { counts: 4 | ODD_RUN, sum: [-1.0; 3], ..run }];
        assert!(on_device(&[], &records) == on_host(&records), "{value}");
    }
    // A film whose words do not borrow is found.
    assert!(on_device(&[BORROWS_NOT], &records) != host);
}

/// Each of the nine sums saturates by itself, whether by one value or by the sum of many, and stays so.
#[test]
fn sums_saturate_on_their_own() {
    let one = |sum: [f32; 3], squared_deviations: [f32; 3], counts: u32| Run {
        sum,
        squared_deviations,
        counts,
        ..Run::default()
    };
    for channel in 0..3 {
        let only = |value: f32| std::array::from_fn(|c| if c == channel { value } else { 1.0 });
        let large = [
            vec![one(only(2f32.powi(39)), [1.0; 3], 8)],
            vec![one(only(2f32.powi(38)), [1.0; 3], 8 | ODD_RUN); 2],
            vec![one(only(2f32.powi(38)), [1.0; 3], 8); 3],
            vec![one([1.0; 3], only(2f32.powi(30)), 8); 2],
            vec![one([1.0; 3], only(2f32.powi(30)), 8 | ODD_RUN); 5],
        ];
        for mut records in large {
            records.extend([one([0.5; 3], [0.5; 3], 8), one([0.5; 3], [0.5; 3], 8 | ODD_RUN)]);
            assert!(on_device(&[], &records) == on_host(&records), "{records:?}");
            assert_eq!(on_device(&[], &records).relative_error(), None);
        }
    }
}

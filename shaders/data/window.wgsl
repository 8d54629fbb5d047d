// The runs that may be started now. A run is up to RUN_LENGTH consecutive samples of one pixel, cut at multiples of
// RUN_LENGTH. Run i of the window belongs to sample block first_block + i / pixels, and to the pixel of index first_pixel + i % pixels
// (step/pixel_order).
struct Window {
    first_block: u32,
    // One past the last run of the window.
    end: u32,
    // Bounces of a dispatch, where one kernel does several.
    bounces: u32,
    // The tile of the film: its first index, and its number of pixels.
    first_pixel: u32,
    pixels: u32,
    // 1 as long as the submission's slots have no run of this window, else 0.
    begins: u32,
    // The number of the submission.
    receipt: u32,
    // The slots of the submission: the first, and one past the last.
    first_slot: u32,
    end_slot: u32,
}

const RUN_LENGTH: u32 = ${run_length}u;
// Rows of the strips in which slots take pixels (step/pixel_order).
const STRIP_ROWS: u32 = 8u;
// Flags above a run's counts. The run is an odd one.
const ODD_RUN: u32 = 0x80000000u;
// The run has sample 0, and `--aov` asks what that sees.
const FIRST_RUN: u32 = 0x40000000u;

// One past the last sample of the run that a sample is part of.
fn end_of_run(sample: u32, end_sample: u32) -> u32 {
    return min((sample / RUN_LENGTH + 1u) * RUN_LENGTH, end_sample);
}

// The number of bins in which light of narrow lobes is counted.
const LIGHT_BINS: u32 = 32u;

// What the device counts for the host, which resets it while nothing runs.
struct Counters {
    // Next run of the window to be started.
    next: atomic<u32>,
    // Records of finished runs that the film does not have yet.
    records: atomic<u32>,
    // Slots without a run.
    idle: atomic<u32>,
    // Samples rejected as NaN, as infinite, as cut short, and because the sum of their run was negative or NaN.
    nan: atomic<u32>,
    infinite: atomic<u32>,
    cut: atomic<u32>,
    refused: atomic<u32>,
    // The number of the last submission whose kernels have all run.
    receipt: u32,
    // Counts of 64 bits, the low word first (step/count).
    counts: array<array<atomic<u32>, 2>, 6>,
    //@ if probed
    // Light of narrow lobes for each bin, in units of 2^-24: what probes found, and what paths found (step/narrow_lobe).
    light: array<array<array<atomic<u32>, 2>, 2>, LIGHT_BINS>,
    //@ end
}

// Camera samples of finished runs, and the rays traced for them.
const PATHS: u32 = 0u;
const RAYS: u32 = 1u;
// Paths that max_depth ended, and the sum of the largest component of their throughput in units of 2^-16, rounded up.
const TOO_DEEP: u32 = 2u;
const TOO_DEEP_THROUGHPUT: u32 = 3u;
// Light paths of even runs. Those of odd runs follow.
const LIGHT_PATHS: u32 = 4u;

// A finished run, on its way to the film.
struct RunRecord {
    // The sum of the radiance of the accepted samples, in device units.
    sum_r: f32,
    sum_g: f32,
    sum_b: f32,
    pixel: u32,
    // Accepted | rejected as NaN << 8 | rejected as infinite << 16 | rejected as cut short << 24 | FIRST_RUN | ODD_RUN.
    counts: u32,
    rays: u32,
    // The sum of the squared deviations of those samples from their mean.
    squares_r: f32,
    squares_g: f32,
    squares_b: f32,
    //@ if aov
    // The sums of `--aov`, over all samples.
    aov: array<f32, ${path_sums}>,
    //@ end
}

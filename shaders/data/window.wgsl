// The runs that may be started now. A run is up to RUN_LENGTH consecutive samples of one pixel, cut at multiples of
// RUN_LENGTH; run i of the window belongs to sample block first_block + i / pixels.
struct Window {
    first_block: u32,
    // One past the last run of the window.
    end: u32,
    // Bounces of a dispatch, where one kernel does several.
    bounces: u32,
}

const RUN_LENGTH: u32 = ${run_length}u;
// Of a run's counts: it is an odd one. The counts proper end below that bit.
const ODD_RUN: u32 = 0x80000000u;

// One past the last sample of the run that a sample is part of.
fn end_of_run(sample: u32, end_sample: u32) -> u32 {
    return min((sample / RUN_LENGTH + 1u) * RUN_LENGTH, end_sample);
}

// What the device counts for the host. Reset by the host while nothing runs.
struct Counters {
    // Next run of the window to be started.
    next: atomic<u32>,
    // Records written since the host last read them.
    records: atomic<u32>,
    // Slots without a run.
    idle: atomic<u32>,
    // Paths that max_depth ended, and the sum of the largest component of their throughput in units of 2^-16, rounded up, in two words.
    too_deep: atomic<u32>,
    too_deep_low: atomic<u32>,
    too_deep_high: atomic<u32>,
    //@ if one_way
    // Of each bin of lights what mirrors and glass may send of it, and what was met of it there: in units of 2^-24, the low word and the high
    // one (step/through_glass).
    light: array<array<atomic<u32>, 4>, 32>,
    //@ end
}

// A finished run.
struct RunRecord {
    // Sum of the radiance of the accepted samples, in device units.
    r: f32,
    g: f32,
    b: f32,
    pixel: u32,
    // Accepted | rejected as NaN << 8 | rejected as infinite << 16 | rejected as cut short << 24 | ODD_RUN.
    counts: u32,
    rays: u32,
    // Sum of the squared deviations of those samples from their mean.
    spread_r: f32,
    spread_g: f32,
    spread_b: f32,
}

// What the film holds of a pixel: sums in fixed point, so that the order of the runs does not matter.
struct PixelTotals {
    // Accepted samples of even runs and of odd ones.
    samples: array<atomic<u32>, 2>,
    // Runs with at least one accepted sample.
    runs: atomic<u32>,
    rejected: atomic<u32>,
    // A bit for each sum that has left its range. The sums from the last bit on share it.
    saturated: atomic<u32>,
    // Sums, each an integer of 128 bits (two's complement) in four words, the lowest first. Nine are of every film: the radiance of even
    // runs (red, green, blue), the radiance of odd runs, and the squared deviations of the samples from the means of their runs. The sums of
    // further channels follow (`--aov`), and with light paths nine more: the splats of even runs, those of odd runs, and the squares of
    // the splats.
    sums: array<array<atomic<u32>, 4>, ${film_sums}>,
    //@ if truth
    // What sample 0 sees (stage/truth).
    stored: array<u32, ${stored_words}>,
    //@ end
    //@ if aov.lights
    // A bit for each group of lights with a sum that has left its range. Their sums stand before those of splats.
    saturated_groups: array<atomic<u32>, ${words_of_groups}>,
    //@ end
    //@ if mattes
    // A table for each kind of matte (aov/mattes): MATTE_SLOTS times an id, or 0, with the number of its camera samples; then the number of those
    // for whose ids there is no room.
    mattes: array<array<atomic<u32>, MATTE_WORDS>, ${matte_kinds}>,
    //@ end
}

// Bits after the binary point of a sum of radiance, in device units, and of a sum of squares, in device units squared.
const SUM_FRACTION: u32 = 88u;
const SQUARE_FRACTION: u32 = 96u;

// The ids in a table of mattes, and its words.
const MATTE_SLOTS: u32 = 16u;
const MATTE_WORDS: u32 = 33u;

// The bit of `saturated` that belongs to a sum.
fn saturated_bit(sum: u32) -> u32 {
    return 1u << min(sum, 31u);
}

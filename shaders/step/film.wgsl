//@ use bind/film
//@ use bind/counters
//@ use choice/filter_weight
//@ use choice/saturation
//@ relies on bits
// Adds finished runs to the film.

const FIRST_SQUARE: u32 = 6u;

// Whether a component is negative or NaN.
fn is_negative_or_nan(v: vec3<f32>) -> bool {
    let bits = bitcast<vec3<u32>>(v);
    return any((bits > vec3<u32>(0x7f800000u)) & (bits != vec3<u32>(0x80000000u)));
}

// Adds a value to a sum of a pixel, rounded to the nearest multiple of 2^-fraction (halves away from 0). atomicAdd and atomicSub return
// the word before, which shows whether it carries or borrows.
fn add_to_film(pixel: u32, sum: u32, value: f32, fraction: u32) {
    let bits = bitcast<u32>(value) & 0x7fffffffu;
    // value = mantissa * 2^(exponent - 150) (IEEE 754-2019, section 3.4). Subnormal numbers round to 0 in either fixed point.
    let exponent = i32(bits >> 23u);
    let mantissa = (bits & 0x7fffffu) | 0x800000u;
    let shift = exponent - 150 + i32(fraction);
    if exponent == 0 || shift < -24 {
        return;
    }
    // The mantissa has 24 bits, and the sum 127 and a sign.
    if shift > 103 {
        mark_saturated(pixel, sum);
        return;
    }
    let left_shift = u32(max(shift, 0));
    let within = left_shift % 32u;
    var low = mantissa << within;
    var high = (mantissa >> 1u) >> (31u - within);
    if shift < 0 {
        let lost = u32(-shift);
        low = (mantissa + (1u << (lost - 1u))) >> lost;
        high = 0u;
    }
    var word = left_shift / 32u;
    let negative = value < 0.0;
    while word < 4u && (low | high) != 0u {
        var before = 0u;
        var after = 0u;
        if negative {
            before = atomicSub(&film[pixel].sums[sum][word], low);
            after = before - low;
            low = high + borrow(before, low);
        } else {
            before = atomicAdd(&film[pixel].sums[sum][word], low);
            after = before + low;
            low = high + carry(before, low);
        }
        // The highest bit is the sum's sign, and shows where the sum leaves its range of ±2^127. `low` may be a carry of the words below.
        if word == 3u && ((before ^ after) >> 31u) == 1u && (before >> 31u == 1u) == negative {
            mark_saturated(pixel, sum);
        }
        high = 0u;
        word++;
    }
}

// Adds a finished run to a pixel of the tile. Returns the number of its samples, rejected ones included.
fn add_run(pixel: u32, run: RunRecord) -> u32 {
    let accepted = run.counts & 0xffu;
    let nan = (run.counts >> 8u) & 0xffu;
    let infinite = (run.counts >> 16u) & 0xffu;
    // ODD_RUN and FIRST_RUN are the highest bits.
    let cut = (run.counts >> 24u) & 0x3fu;
    let half = run.counts >> 31u;
    let sum = vec3<f32>(run.sum_r, run.sum_g, run.sum_b);
    let squares = vec3<f32>(run.squares_r, run.squares_g, run.squares_b);
    var rejected = nan + infinite + cut;
    if rejected != 0u {
        atomicAdd(&counters.nan, nan);
        atomicAdd(&counters.infinite, infinite);
        atomicAdd(&counters.cut, cut);
    }
    if is_negative_or_nan(unsigned_sum(sum)) || is_negative_or_nan(squares) {
        atomicAdd(&counters.refused, accepted);
        rejected += accepted;
    } else if is_infinite(sum.x) || is_infinite(sum.y) || is_infinite(sum.z) {
        // The samples are finite and their sum is not: too bright for the device's unit of radiance.
        atomicAdd(&counters.infinite, accepted);
        rejected += accepted;
    } else if accepted != 0u {
        for (var i = 0u; i < 3u; i++) {
            add_to_film(pixel, 3u * half + i, sum[i], SUM_FRACTION);
            add_to_film(pixel, FIRST_SQUARE + i, squares[i], SQUARE_FRACTION);
        }
        atomicAdd(&film[pixel].samples[half], accepted);
        atomicAdd(&film[pixel].runs, 1u);
    }
    if rejected != 0u {
        atomicAdd(&film[pixel].rejected, rejected);
    }
    return accepted + nan + infinite + cut;
}

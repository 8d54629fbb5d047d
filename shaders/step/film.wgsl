//@ use bind/film
//@ use bind/counters
//@ use lib/carry
//@ use lib/float
//@ relies on bits
// Adds finished runs to the film.

const FIRST_SQUARE: u32 = 6u;

// Whether a component is negative or NaN, which a sum of accepted samples never is.
fn is_no_sum(v: vec3<f32>) -> bool {
    let bits = bitcast<vec3<u32>>(v);
    return any((bits > vec3<u32>(0x7f800000u)) & (bits != vec3<u32>(0x80000000u)));
}

// Adds a value, not negative, to a sum of a pixel, rounded to the nearest multiple of 2^-fraction (halves up). atomicAdd returns what the word
// was before, which tells whether it carries.
fn add_to_film(pixel: u32, sum: u32, value: f32, fraction: u32) {
    let bits = bitcast<u32>(value) & 0x7fffffffu;
    // value = mantissa * 2^(exponent - 150) (IEEE 754-2019, section 3.4). Subnormal numbers round to 0 in either fixed point.
    let exponent = i32(bits >> 23u);
    let mantissa = (bits & 0x7fffffu) | 0x800000u;
    let shift = exponent - 150 + i32(fraction);
    if exponent == 0 || shift < -24 {
        return;
    }
    // The mantissa has 24 bits.
    if shift > 104 {
        atomicOr(&film[pixel].saturated, 1u << sum);
        return;
    }
    let places = u32(max(shift, 0));
    let within = places % 32u;
    var low = mantissa << within;
    var high = (mantissa >> 1u) >> (31u - within);
    if shift < 0 {
        let lost = u32(-shift);
        low = (mantissa + (1u << (lost - 1u))) >> lost;
        high = 0u;
    }
    var word = places / 32u;
    while word < 4u && (low | high) != 0u {
        let before = atomicAdd(&film[pixel].sums[sum][word], low);
        low = high + carry(before, low);
        high = 0u;
        word++;
    }
    if low != 0u {
        atomicOr(&film[pixel].saturated, 1u << sum);
    }
}

// Adds a finished run to a pixel of the tile. Returns its samples.
fn add_run(pixel: u32, run: RunRecord) -> u32 {
    let accepted = run.counts & 0xffu;
    let nan = (run.counts >> 8u) & 0xffu;
    let infinite = (run.counts >> 16u) & 0xffu;
    // ODD_RUN is the highest bit.
    let cut = (run.counts >> 24u) & 0x7fu;
    let half = run.counts >> 31u;
    let sum = vec3<f32>(run.sum_r, run.sum_g, run.sum_b);
    let spread = vec3<f32>(run.spread_r, run.spread_g, run.spread_b);
    var rejected = nan + infinite + cut;
    if rejected != 0u {
        atomicAdd(&counters.nan, nan);
        atomicAdd(&counters.infinite, infinite);
        atomicAdd(&counters.cut, cut);
    }
    if is_no_sum(sum) || is_no_sum(spread) {
        atomicAdd(&counters.refused, accepted);
        rejected += accepted;
    } else if is_infinite(sum.x) || is_infinite(sum.y) || is_infinite(sum.z) {
        // Finite samples whose sum is not: too bright for the device's unit.
        atomicAdd(&counters.infinite, accepted);
        rejected += accepted;
    } else if accepted != 0u {
        for (var i = 0u; i < 3u; i++) {
            add_to_film(pixel, 3u * half + i, sum[i], SUM_FRACTION);
            add_to_film(pixel, FIRST_SQUARE + i, spread[i], SQUARE_FRACTION);
        }
        atomicAdd(&film[pixel].samples[half], accepted);
        atomicAdd(&film[pixel].runs, 1u);
    }
    if rejected != 0u {
        atomicAdd(&film[pixel].rejected, rejected);
    }
    return accepted + nan + infinite + cut;
}

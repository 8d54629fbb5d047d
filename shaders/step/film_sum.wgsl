//@ use bind/film
//@ use lib/carry
// Adds a value to a sum of a pixel, rounded to the nearest multiple of 2^-fraction (halves away from 0). atomicAdd and atomicSub return what
// the word was before, which tells whether it carries or borrows.
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
        // The highest bit is the sum's sign. It shows where the sum leaves its range of ±2^127. Words below come here with `low`.
        if word == 3u && ((before ^ after) >> 31u) == 1u && (before >> 31u == 1u) == negative {
            atomicOr(&film[pixel].saturated, 1u << sum);
        }
        high = 0u;
        word++;
    }
}

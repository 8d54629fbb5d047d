//@ use bind/film
//@ use bind/counters
//@ use lib/float
//@ use step/film_sum
//@ relies on bits
// Adds finished runs to the film.

const FIRST_SQUARE: u32 = 6u;

// Whether a component is negative or NaN.
fn is_no_sum(v: vec3<f32>) -> bool {
    let bits = bitcast<vec3<u32>>(v);
    return any((bits > vec3<u32>(0x7f800000u)) & (bits != vec3<u32>(0x80000000u)));
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
    var unsigned = sum;
    //@ if signed
    // A filter with negative lobes makes sums of either sign.
    unsigned = abs(sum);
    //@ end
    if is_no_sum(unsigned) || is_no_sum(spread) {
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

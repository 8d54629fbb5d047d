// Facts about f32 that hold on every driver. NaN and infinity are tested by bits, because a compiler may assume that they do not occur.

// Half an ulp of 1: the relative error of one correctly rounded operation.
const UNIT_ROUNDOFF: f32 = 0x1p-24f;
// Stands for "no bound". A compiler may assume that infinities do not occur (WGSL section 15.7.2).
const VERY_FAR: f32 = 0x1p126f;

fn is_nan(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7fffffffu) > 0x7f800000u;
}

fn is_infinite(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7fffffffu) == 0x7f800000u;
}

// The float next to x in the direction of `toward`'s sign. It is x itself if either is zero or x is subnormal, because the
// neighbours of zero may be flushed back to zero.
fn next_float(x: f32, toward: f32) -> f32 {
    let bits = bitcast<u32>(x);
    let steady = (bits & 0x7f800000u) == 0u || toward == 0.0;
    let away_from_zero = (x > 0.0) == (toward > 0.0);
    let moved = select(bits - 1u, bits + 1u, away_from_zero);
    return bitcast<f32>(select(moved, bits, steady));
}

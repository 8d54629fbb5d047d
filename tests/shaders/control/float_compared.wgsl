// Wrong on purpose: a NaN is sought by comparing it with itself, which a compiler may assume to be equal.
const UNIT_ROUNDOFF: f32 = 0x1p-24f;
const VERY_FAR: f32 = 0x1p126f;

fn is_nan(x: f32) -> bool {
    return x != x;
}

fn is_infinite(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7fffffffu) == 0x7f800000u;
}

fn next_float(x: f32, toward: f32) -> f32 {
    let bits = bitcast<u32>(x);
    let steady = (bits & 0x7f800000u) == 0u || toward == 0.0;
    let moved = select(bits - 1u, bits + 1u, (x > 0.0) == (toward > 0.0));
    return bitcast<f32>(select(moved, bits, steady));
}

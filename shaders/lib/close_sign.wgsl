//@ relies on signs
// The exact sign of a difference of two products.

// |x y| exactly, for normal floats: an integer of two digits in base 2^24, times 2 to the power of the sum of the exponents.
struct ExactProduct {
    high: u32,
    low: u32,
    exponent: u32,
}

fn exact_product(x: f32, y: f32) -> ExactProduct {
    let x_bits = bitcast<u32>(x);
    let y_bits = bitcast<u32>(y);
    let m = (x_bits & 0x7fffffu) | 0x800000u;
    let n = (y_bits & 0x7fffffu) | 0x800000u;
    let middle = (m >> 12u) * (n & 0xfffu) + (m & 0xfffu) * (n >> 12u);
    let low = (m & 0xfffu) * (n & 0xfffu) + ((middle & 0xfffu) << 12u);
    return ExactProduct(
        (m >> 12u) * (n >> 12u) + (middle >> 12u) + (low >> 24u),
        low & 0xffffffu,
        ((x_bits >> 23u) & 255u) + ((y_bits >> 23u) & 255u),
    );
}

// The sign of p.x q.y - p.y q.x. The two products, as floats, must be both 0 or differ by a few roundings; their exponents then
// differ by at most one. If the exact difference is 0, (e, e^2) with an infinitesimal e > 0 is subtracted from both points, and
// the sign is that of e (p.y - q.y) + e^2 (q.x - p.x) + 0 e^3. Only p = q gives 0.
fn close_sign(px: f32, py: f32, qx: f32, qy: f32) -> f32 {
    let one = exact_product(px, qy);
    let other = exact_product(py, qx);
    // If the exponents differ, the digits of the product with the larger exponent are doubled.
    let one_doubled = select(0u, 1u, one.exponent > other.exponent);
    let other_doubled = select(0u, 1u, other.exponent > one.exponent);
    let high = i32(one.high << one_doubled) - i32(other.high << other_doubled);
    let low = i32(one.low << one_doubled) - i32(other.low << other_doubled);
    // |low| is below 2 x 2^24. So if the high digits differ by more than 4, they alone decide.
    let larger = sign(clamp(high, -4, 4) * 0x1000000 + low);
    let difference = sign(px * qy) * f32(larger);
    let moved_x = select(select(0.0, -1.0, qx < px), 1.0, qx > px);
    let moved_y = select(select(moved_x, -1.0, py < qy), 1.0, py > qy);
    return select(moved_y, difference, difference != 0.0);
}

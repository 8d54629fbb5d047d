//@ alternative filter when filter.mitchell
// The cubic filter f(x) f(y) of Mitchell and Netravali with B = C = 1/3 ("Reconstruction filters in computer graphics", SIGGRAPH
// 1988, equation 8), four pixels wide. It is negative between 8/7 and 2 pixels from the middle. So points have the density |f|, and
// samples the weight sign(f) ∫|f| / ∫f along each axis (Ernst, Stamminger, Greiner, "Filter importance sampling", 2006).

// ∫|f| along an axis, where ∫f is 1: twice the area of the negative lobes more, 2 · 12/343.
const ABSOLUTE: f32 = 1.0699708454810495;
const ZERO: f32 = 8.0 / 7.0;

// ∫|f| from 0 to x. With y = 2 - x, f = 7/18 y³ - 1/3 y² beyond 1.
fn absolute_area(x: f32) -> f32 {
    if x < 1.0 {
        return x * (8.0 / 9.0 + x * x * (x * (7.0 / 24.0) - 2.0 / 3.0));
    }
    let y = 2.0 - x;
    let beyond = y * y * y * (1.0 / 9.0 - y * (7.0 / 72.0));
    // Up to the zero ∫f is 1/2 + 6/343. What is left there of `beyond` is 6/343.
    return select(0.5349854227405248 - beyond, 0.5 + beyond, x < ZERO);
}

// The share of it up to the zero.
const POSITIVE: f32 = 0.967302452316076;

// The distance from the middle within which a share of ∫|f| lies. The area rises, so that halving an interval finds it up to 2^-11
// pixels, where it is a straight line.
fn distance_of(share: f32) -> f32 {
    let area = share * (0.5 * ABSOLUTE);
    var low = 0.0;
    var area_below = 0.0;
    var area_above = 0.5 * ABSOLUTE;
    var width = 2.0;
    for (var i = 0; i < 12; i++) {
        width *= 0.5;
        let middle = absolute_area(low + width);
        if middle <= area {
            low += width;
            area_below = middle;
        } else {
            area_above = middle;
        }
    }
    let rise = area_above - area_below;
    return low + select(0.0, width * ((area - area_below) / rise), rise > 0.0);
}

fn filter_point(u: vec2<f32>) -> vec2<f32> {
    let share = abs(2.0 * u - 1.0);
    let distance = vec2<f32>(distance_of(share.x), distance_of(share.y));
    return vec2<f32>(0.5) + select(distance, -distance, u < vec2<f32>(0.5));
}

// The weight of the sample at `filter_point(u)`.
fn filter_weight(u: vec2<f32>) -> f32 {
    let share = abs(2.0 * u - 1.0);
    return select(-1.0, 1.0, (share.x > POSITIVE) == (share.y > POSITIVE)) * (ABSOLUTE * ABSOLUTE);
}

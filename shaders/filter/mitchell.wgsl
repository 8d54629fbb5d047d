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

// The distance from the middle within which a share of ∫|f| lies. The area rises, so that halving an interval finds it.
fn distance_of(share: f32) -> f32 {
    let area = share * (0.5 * ABSOLUTE);
    var low = 0.0;
    var step = 1.0;
    for (var i = 0; i < 24; i++) {
        if absolute_area(low + step) <= area {
            low += step;
        }
        step *= 0.5;
    }
    return low;
}

fn distances(u: vec2<f32>) -> vec2<f32> {
    let share = abs(2.0 * u - 1.0);
    return vec2<f32>(distance_of(share.x), distance_of(share.y));
}

fn filter_point(u: vec2<f32>) -> vec2<f32> {
    let offset = distances(u);
    return vec2<f32>(0.5) + select(offset, -offset, u < vec2<f32>(0.5));
}

// The weight of the sample at `filter_point(u)`.
fn filter_weight(u: vec2<f32>) -> f32 {
    let offset = distances(u);
    return select(-1.0, 1.0, (offset.x > ZERO) == (offset.y > ZERO)) * (ABSOLUTE * ABSOLUTE);
}

//@ use bind/settings
//@ relies on loops
// How far from the middle a calibrated lens shows x, which is an angle or a distance: x + k1 x³ + k2 x⁵ + k3 x⁷ + k4 x⁹. `distortion` has k1 to k4, and
// `fold` the largest x, from which on the image would lie nearer to the middle.

// The distance, and its derivative.
fn radial_of(x: f32) -> vec2<f32> {
    let k = settings.distortion;
    let s = x * x;
    let distance = x * (1.0 + s * (k.x + s * (k.y + s * (k.z + s * k.w))));
    return vec2<f32>(distance, 1.0 + s * (3.0 * k.x + s * (5.0 * k.y + s * (7.0 * k.z + s * 9.0 * k.w))));
}

// The inverse by Newton's steps, halved where one would leave the interval that holds the root: between two bends of the curve they may go in circles.
const MOST_STEPS_OF_NEWTON: u32 = 128u;

fn inverse_radial(distance: f32) -> f32 {
    var low = 0.0;
    var high = settings.fold;
    var x = min(distance, high);
    for (var i = 0u; i < MOST_STEPS_OF_NEWTON; i++) {
        let found = radial_of(x);
        let is_below = found.x < distance;
        low = select(low, x, is_below);
        high = select(x, high, is_below);
        let next = x + (distance - found.x) / found.y;
        let step = select(0.5 * (low + high), next, next >= low && next <= high) - x;
        x += step;
        if abs(step) <= 1e-7 * x {
            break;
        }
    }
    return x;
}

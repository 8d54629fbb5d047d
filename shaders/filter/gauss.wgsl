//@ alternative filter when filter.gauss
// A point around the middle of a pixel with a Gaussian density of standard deviation 1/2 pixel, cut off at a distance of 1.5
// pixels (Box and Muller, "A note on the generation of random normal deviates", Annals of Mathematical Statistics 29(2), 1958).
// WGSL promises a logarithm near 1 to 2^-21: the point is off by 5e-4 pixels at most.

// The share of the Gaussian within that distance: 1 - exp(-1.5² / (2 · 0.5²)).
const WITHIN: f32 = 0.9888910034617577;

fn filter_point(u: vec2<f32>) -> vec2<f32> {
    let distance = sqrt(-0.5 * log(1.0 - WITHIN * u.x));
    return vec2<f32>(0.5) + distance * sample_circle(u.y);
}

// Maps from uniform numbers in [0, 1) to the distributions that the renderer samples.

const PI: f32 = 3.14159265358979;

// A point on the unit circle. u = 0 gives (-1, 0).
fn sample_circle(u: f32) -> vec2<f32> {
    return circle_point(u - 0.5);
}

// Uniform over the unit disk, by area.
fn sample_disk(u: vec2<f32>) -> vec2<f32> {
    return sqrt(u.x) * sample_circle(u.y);
}

// Cosine-weighted around +z: pdf cos(theta) / pi. Malley's method (Pharr, Jakob, Humphreys, PBR 4th ed., A.5.3). z is never
// below 2^-12, but for the root's rounding, because 1 - u is never below 2^-24.
fn sample_cosine_hemisphere(u: vec2<f32>) -> vec3<f32> {
    return vec3<f32>(sample_disk(u), sqrt(1.0 - u.x));
}

// Uniform over the unit sphere's surface: pdf 1 / (4 pi) (PBR 4th ed., A.5.2).
fn sample_sphere(u: vec2<f32>) -> vec3<f32> {
    let z = 1.0 - 2.0 * u.x;
    let r = 2.0 * sqrt(u.x * (1.0 - u.x));
    return vec3<f32>(r * sample_circle(u.y), z);
}

// Uniform over the unit ball's volume: the radius r has the cumulative distribution r^3.
fn sample_ball(u: vec3<f32>) -> vec3<f32> {
    return cube_root(u.z) * sample_sphere(u.xy);
}

// x^(1/3) for x in [0, 1), zero at zero.
fn cube_root(x: f32) -> f32 {
    return select(exp2(log2(x) * (1.0 / 3.0)), 0.0, x == 0.0);
}

//@ use medium/free_flight
// Densities that fall exponentially with height. Along a ray, the logarithm of the density is a line with this slope. All formulas are
// integrals of exp and their inverses (own derivation), written so that neither a steep nor a flat slope overflows or cancels.

// 1 - z / 2 + z^2 / 6 …: the mean of exp(-x) for x from 0 to z.
fn mean_of_fall(z: f32) -> f32 {
    let series = 1.0 - z * (0.5 - z * (1.0 / 6.0 - z * (1.0 / 24.0 - z * (1.0 / 120.0))));
    return select((1.0 - exp(-z)) / z, series, z < 0.1);
}

// The optical depth of a part of a ray of this length. `log_density` is that where the part begins.
fn depth_by_height(log_density: f32, slope: f32, length: f32) -> f32 {
    let densest = log_density + max(slope, 0.0) * length;
    return exp(densest) * length * mean_of_fall(abs(slope) * length);
}

// The length of the ray after which its optical depth is `depth` > 0; VERY_FAR if it never is.
fn length_by_height(log_density: f32, slope: f32, depth: f32) -> f32 {
    // The logarithm of the length if the density did not change, and of that times the slope.
    let log_length = log(depth) - log_density;
    let length = exp(min(log_length, 80.0));
    let z = abs(slope) * length;
    if z < 0.01 {
        let s = slope * length;
        return length * (1.0 - s * (0.5 - s * (1.0 / 3.0 - s * 0.25)));
    }
    if slope < 0.0 {
        return select(VERY_FAR, log(1.0 - z) / slope, z < 1.0);
    }
    // Far below, 1 is nothing beside a z that may overflow.
    let log_z = log_length + log(slope);
    return select(log(1.0 + z), log_z, log_z > 20.0) / slope;
}

// The distance of the next event in an interval of a ray in the field, or NO_HIT.
fn event_in_height(
    field: ScalarField,
    ray: Ray,
    inside: vec2<f32>,
    words: ptr<function, vec4<u32>>,
    steps: ptr<function, u32>,
) -> f32 {
    let slope = ray.direction.x;
    let depth = max(optical_depth((*words).xy), 0x1p-60f);
    let t = inside.x + length_by_height(ray.origin.x + inside.x * slope, slope, depth);
    return select(NO_HIT, t, t < inside.y);
}

// The share of light that passes the interval.
fn share_through_height(
    field: ScalarField,
    ray: Ray,
    inside: vec2<f32>,
    words: ptr<function, vec4<u32>>,
    steps: ptr<function, u32>,
) -> f32 {
    let slope = ray.direction.x;
    return exp(-depth_by_height(ray.origin.x + inside.x * slope, slope, inside.y - inside.x));
}

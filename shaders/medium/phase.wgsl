// Scattering in a medium: Henyey and Greenstein, "Diffuse radiation in the Galaxy", ApJ 93, 1941.

// 1 - cos and 1 + cos of the angle between the old and the new direction, without cancellation for any g. Let h = |g| and D = 1 -
// h + 2 h u. The inverse of the cumulative distribution is cos = (1 + h^2 - ((1 - h^2) / D)^2) / 2h (PBR 4th ed., section 11.3.1,
// with u from the other end). Factoring it gives 1 - cos = 2 ((1 - h) / D)^2 (1 - u) (1 + h u) and 1 + cos = 2 ((1 + h) / D)^2 u
// (1 - h + h u) (own derivation). A negative g exchanges the two. `one_minus_g` is 1 - |g| > 0, which the host computes in f64.
fn henyey_greenstein(g: f32, one_minus_g: f32, u: f32) -> vec2<f32> {
    let h = abs(g);
    let d = one_minus_g + 2.0 * h * u;
    let back = one_minus_g / d;
    let ahead = (1.0 + h) / d;
    let one_minus_cos = 2.0 * (back * back) * ((1.0 - u) * (1.0 + h * u));
    let one_plus_cos = 2.0 * (ahead * u) * (ahead * (one_minus_g + h * u));
    return select(vec2<f32>(one_minus_cos, one_plus_cos), vec2<f32>(one_plus_cos, one_minus_cos), g < 0.0);
}

// Samples the new direction of light that travels along the unit vector `incoming`. g > 0 scatters forwards.
fn sample_phase(incoming: vec3<f32>, g: f32, one_minus_g: f32, u: vec2<f32>) -> vec3<f32> {
    let from_one = henyey_greenstein(g, one_minus_g, u.x);
    let cos = select(from_one.y - 1.0, 1.0 - from_one.x, from_one.x < 1.0);
    let sin = sqrt(from_one.x * from_one.y);
    return normalize(from_basis(basis_around(incoming), vec3<f32>(sin * sample_circle(u.y), cos)));
}

// The pdf of Henyey and Greenstein's phase function in solid angle: (1 - g^2) / (4 pi (1 + g^2 - 2 g cos)^(3/2)). Let h = |g|, and
// measure the angle from the direction of the peak: forwards for g > 0, backwards for g < 0. Then 1 + g^2 - 2 g cos = (1 - h)^2 + 2 h (1
// - cos), and 1 - cos is half the squared difference of the two directions, so nothing cancels near the peak. `one_minus_g` is 1 - |g|.
fn phase_pdf(incoming: vec3<f32>, direction: vec3<f32>, g: f32, one_minus_g: f32) -> f32 {
    let h = abs(g);
    let apart = direction - select(-incoming, incoming, g >= 0.0);
    let d = one_minus_g * one_minus_g + h * dot(apart, apart);
    return one_minus_g * (1.0 + h) / (4.0 * PI * d * sqrt(d));
}

// The width in radians of the phase function's peak, of which `one_minus_g` is 1 - |g|: half of the directions are within about this angle of
// the axis, as the inverse of the distribution has it for g close to 1 (medium/phase, at u = 1/2).
fn width_of_phase(one_minus_g: f32) -> f32 {
    return 1.7320508 * one_minus_g;
}

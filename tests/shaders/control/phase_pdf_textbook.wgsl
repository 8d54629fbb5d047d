// Wrong on purpose: the denominator by the cosine, which cancels near the peak.
fn phase_pdf(incoming: vec3<f32>, direction: vec3<f32>, g: f32, one_minus_g: f32) -> f32 {
    let d = 1.0 + g * g - 2.0 * g * dot(incoming, direction);
    return (1.0 - g * g) / (4.0 * PI * d * sqrt(d));
}

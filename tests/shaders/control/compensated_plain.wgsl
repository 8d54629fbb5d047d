// A sum that forgets what it loses to rounding.
fn compensated_sum(before: Compensated, term: vec3<f32>, zero: u32) -> Compensated {
    return Compensated(before.sum + term, vec3<f32>(0.0));
}

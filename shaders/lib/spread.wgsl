// How a run's samples are spread: their squared deviations from their mean, summed as they come (Welford, "Note on a method for
// calculating corrected sums of squares and products", Technometrics 4(3), 1962).

// What a sample adds to the squared deviations of `others` samples whose sum is `sum`.
fn spread_by(others: u32, sum: vec3<f32>, sample: vec3<f32>) -> vec3<f32> {
    let n = f32(others);
    let deviation = sample - sum / max(n, 1.0);
    return deviation * (deviation * (n / (n + 1.0)));
}

// The sum of the squared deviations of a run's samples from their mean, updated with each sample (Welford, "Note
// on a method for calculating corrected sums of squares and products", Technometrics 4(3), 1962).

// How much a sample adds to the sum of squared deviations of `others` samples whose sum is `sum`.
fn squared_deviation(others: u32, sum: vec3<f32>, sample: vec3<f32>) -> vec3<f32> {
    let n = f32(others);
    let deviation = sample - sum / max(n, 1.0);
    return deviation * (deviation * (n / (n + 1.0)));
}

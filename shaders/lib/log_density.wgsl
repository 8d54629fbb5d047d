// Logarithms (base 2) of densities. Products of many densities leave the range of f32.
const LEAST_DENSITY: f32 = 0x1p-100f;

fn log_of_density(density: f32) -> f32 {
    return log2(max(density, LEAST_DENSITY));
}

// Sheen: the distribution of fibres that is called Charlie, and its visibility (Estevez and Kulla, "Production Friendly Microfacet Sheen
// BRDF", SIGGRAPH 2017 course; in the form of KHR_materials_sheen). alpha is the square of the roughness.

// A roughness below this counts as this: with 0, the density would be infinite at grazing half vectors, and 0 elsewhere.
const LEAST_SHEEN_ROUGHNESS: f32 = 0.07;

fn charlie_alpha(roughness: f32) -> f32 {
    let rough = max(roughness, LEAST_SHEEN_ROUGHNESS);
    return rough * rough;
}

// The density of the fibres' normals; `sine2` is the squared sine of their angle with the surface's normal.
fn charlie_density(sine2: f32, alpha: f32) -> f32 {
    return (2.0 + 1.0 / alpha) * pow(sine2, 0.5 / alpha) * 0.15915494;
}

fn charlie_fit(x: f32, alpha: f32) -> f32 {
    let m = (1.0 - alpha) * (1.0 - alpha);
    let a = mix(21.5473, 25.3245, m);
    let b = mix(3.82987, 3.32435, m);
    let c = mix(0.19823, 0.16801, m);
    let d = mix(-1.97760, -1.27393, m);
    let e = mix(-4.32054, -4.85967, m);
    return a / (1.0 + b * pow(x, c)) + d * x + e;
}

fn charlie_lambda(cosine: f32, alpha: f32) -> f32 {
    // One pair of calls serves both branches.
    let is_low = cosine < 0.5;
    let fit = charlie_fit(select(1.0 - cosine, cosine, is_low), alpha);
    return exp(select(2.0 * charlie_fit(0.5, alpha) - fit, fit, is_low));
}

// Microfacets whose slopes have a normal distribution, of the variance alpha^2 / 2: the distribution of Beckmann (Heitz, "Understanding the
// Masking-Shadowing Function in Microfacet-Based BRDFs", JCGT 3(2), 2014, section 5.2), with the functions of lib/anisotropic_microfacet.

// Slopes beyond this many alphas are those of 1e-12 of the microfacets.
const STEEPEST: f32 = 5.0;
const SQRT_PI: f32 = 1.7724539;

// 1 - erf(x), off by 2e-7 of it where x is not negative (Press et al., "Numerical Recipes", section 6.2).
fn erfc(x: f32) -> f32 {
    let t = 1.0 / (1.0 + 0.5 * abs(x));
    let high = 0.27886807 + t * (-1.13520398 + t * (1.48851587 + t * (-0.82215223 + t * 0.17087277)));
    let series = -1.26551223 + t * (1.00002368 + t * (0.37409196 + t * (0.09678418 + t * (-0.18628806 + t * high))));
    let tail = t * exp(series - x * x);
    return select(2.0 - tail, tail, x >= 0.0);
}

// |v|^4 exp(-(x^2/a^2 + y^2/b^2) / z^2) / (pi a b z^4), with the alphas a and b.
fn beckmann_density(along: vec3<f32>, alphas: vec2<f32>) -> f32 {
    let across = along.xy / (alphas * along.z);
    let slope2 = dot(across, across);
    if !(slope2 < 80.0) {
        return 0.0;
    }
    let ratio = dot(along, along) / (along.z * along.z);
    return ratio * ratio * exp(-slope2) / (PI * alphas.x * alphas.y);
}

// The cosine times 1 + 2 Lambda.
fn beckmann_root(direction: vec3<f32>, alphas: vec2<f32>) -> f32 {
    let spread = length(alphas * direction.xy);
    if !(direction.z < STEEPEST * spread) {
        return direction.z;
    }
    let steepness = direction.z / spread;
    return direction.z * (1.0 - erfc(steepness)) + spread * exp(-steepness * steepness) / SQRT_PI;
}

// The area of the microfacets with slopes up to `slope`, in alphas, as a view at this cosine and sine sees it.
fn seen_up_to(slope: f32, cosine: f32, sine: f32) -> f32 {
    return 0.5 * (cosine * erfc(-slope) + sine * exp(-slope * slope) / SQRT_PI);
}

// A slope along the view, of those that it sees, by Newton's method between bounds: seen_up_to has no closed inverse.
fn sample_slope(u: f32, cosine: f32, sine: f32) -> f32 {
    var least = -STEEPEST;
    var most = select(STEEPEST, cosine / sine, cosine < STEEPEST * sine);
    let goal = u * seen_up_to(most, cosine, sine);
    var slope = 0.5 * min(most, 1.0) - 0.5;
    var step = 1.0;
    for (var i = 0u; i < 40u && abs(step) > 0x1p-20f; i += 1u) {
        let lacking = goal - seen_up_to(slope, cosine, sine);
        least = select(least, slope, lacking >= 0.0);
        most = select(most, slope, lacking <= 0.0);
        let next = slope + lacking * SQRT_PI * exp(slope * slope) / (cosine - slope * sine);
        let following = select(0.5 * (least + most), next, next > least && next < most);
        step = following - slope;
        slope = following;
    }
    return slope;
}

fn sample_beckmann_normal(view: vec3<f32>, alphas: vec2<f32>, u: vec2<f32>) -> vec3<f32> {
    let stretched = normalize(vec3<f32>(alphas * view.xy, view.z));
    let sine = length(stretched.xy);
    let towards = select(vec2<f32>(1.0, 0.0), stretched.xy / sine, sine > 0.0);
    // Across the view, it sees them as from straight above.
    let slopes = vec2<f32>(sample_slope(u.x, stretched.z, sine), sample_slope(u.y, 1.0, 0.0));
    let across = slopes.x * towards + slopes.y * vec2<f32>(-towards.y, towards.x);
    return normalize(vec3<f32>(-alphas * across, 1.0));
}

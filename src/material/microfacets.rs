//! The directional albedo of single scattering by microfacets: a table that shaders/scene/directional_albedo interpolates.

use std::f64::consts::PI;
use std::sync::LazyLock;

use super::width::LEAST_ROUGHNESS;

/// Rows are roughnesses, and columns the cosines of the view.
const ROWS: usize = 32;
const COLUMNS: usize = 32;
/// Midpoints of the integral each way.
const RINGS: u32 = 64;
const SECTORS: u32 = 32;

/// The directional albedo of a rough white metal, four columns an element. Row `i` has the roughness i/31. Column `j` has the
/// cosine at which cosine (1 + alpha)/(cosine + alpha) is j/31, because the albedo changes most where the cosine is about alpha.
pub fn directional_albedos() -> &'static [[f32; 4]] {
    static TABLE: LazyLock<Vec<[f32; 4]>> = LazyLock::new(make_directional_albedos);
    &TABLE
}

fn make_directional_albedos() -> Vec<[f32; 4]> {
    let albedo = |at: usize| {
        let (row, column) = (at / COLUMNS, at % COLUMNS);
        let roughness = (row as f64 / (ROWS - 1) as f64).max(f64::from(LEAST_ROUGHNESS));
        let alpha = roughness * roughness;
        let x = column as f64 / (COLUMNS - 1) as f64;
        // At a grazing view, all light is mirrored to the other side.
        if column == 0 { 1.0 } else { integral(x * alpha / (1.0 + alpha - x), alpha) as f32 }
    };
    (0..ROWS * COLUMNS / 4).map(|four| [0, 1, 2, 3].map(|one| albedo(4 * four + one))).collect()
}

/// The mean of G2 / G1 over the microfacets that the view sees, by the map of shaders/lib/microfacet from the unit square to them. The two
/// sides of the plane of the view are alike.
fn integral(cosine: f64, alpha: f64) -> f64 {
    let root = |cosine: f64| (cosine * cosine + alpha * alpha * (1.0 - cosine) * (1.0 + cosine)).sqrt();
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    let length = (alpha * sine).hypot(cosine);
    let (across, along) = (alpha * sine / length, cosine / length);
    let mut sum = 0.0;
    for ring in 0..RINGS {
        let u = (f64::from(ring) + 0.5) / f64::from(RINGS);
        let from_top = u * (1.0 + along);
        let radius = (from_top * (2.0 - from_top)).sqrt();
        for sector in 0..SECTORS {
            let azimuth = PI * (f64::from(sector) + 0.5) / f64::from(SECTORS);
            let (x, y) = (alpha * (radius * azimuth.cos() + across), alpha * radius * azimuth.sin());
            let z = (1.0 - u) * (1.0 + along);
            let cos_light = 2.0 * (sine * x + cosine * z) * z / (x * x + y * y + z * z) - cosine;
            if cos_light > 0.0 {
                let view = cosine + root(cosine);
                sum += cos_light * view / (cos_light * root(cosine) + cosine * root(cos_light.min(1.0)));
            }
        }
    }
    sum / f64::from(RINGS * SECTORS)
}

//! Boundaries of glass: their numbers as kernels have them, and the widths of their lobes.

use super::width::{LEAST_ROUGHNESS, LobeWidth, least_of_anisotropic, widest_alpha};

/// The index of refraction of glass, and its contrasts (n - 1)(n + 1) from outside and from inside (shaders/lib/fresnel).
pub fn glass_numbers(ior: f64) -> [f64; 3] {
    let contrast = |n: f64| (n - 1.0) * (n + 1.0);
    [ior, contrast(ior), contrast(1.0 / ior)]
}

/// The widths of the lobes of a boundary of this roughness: as is_rough_boundary, width_of_reflection and width_of_refraction from either side
/// have them (shaders/lib/microfacet).
pub fn widths_of_boundary(ior: f64, roughness: f64, anisotropy: f64) -> Vec<LobeWidth> {
    let roughness = least_of_anisotropic(roughness, anisotropy);
    let alpha = roughness.powi(2);
    let [_, outside, _] = glass_numbers(ior);
    if alpha * (outside as f32).abs().min(1.0) < LEAST_ROUGHNESS.powi(2) {
        return vec![LobeWidth::Specular];
    }
    let widest = widest_alpha(roughness, anisotropy);
    [2.0, 1.0 - 1.0 / ior, 1.0 - ior].map(|factor| LobeWidth::of_width(widest * factor.abs() as f32)).to_vec()
}

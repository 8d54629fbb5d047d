//! The widths of lobes, which decide for which of them lights are sampled.

use crate::bitmap::Bitmaps;
use crate::data::NARROW_LOBE;
use crate::texture::Texture;

/// A roughness below this makes a smooth surface, as shaders/lib/microfacet says.
pub const LEAST_ROUGHNESS: f32 = 1.0 / 1024.0;

/// The width of a lobe into which a material scatters. On the device, SHADER_is_non_specular says whether a material has one that is not
/// specular.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum LobeWidth {
    /// A single direction, for which no light can be sampled.
    Specular,
    /// Below [`NARROW_LOBE`], so that light sampling rarely finds a light in it.
    Narrow,
    Wide,
}

/// The widths of lobes of a roughness that may be any.
pub const ANY_WIDTH: &[LobeWidth] = &[LobeWidth::Wide, LobeWidth::Narrow, LobeWidth::Specular];

impl LobeWidth {
    /// A lobe of this width in radians.
    pub fn of_width(width: f32) -> LobeWidth {
        if width < NARROW_LOBE { LobeWidth::Narrow } else { LobeWidth::Wide }
    }

    /// The lobe that microfacets of this roughness and anisotropy reflect, as width_of_reflection (shaders/lib/microfacet).
    pub fn of_facets(roughness: f64, anisotropy: f64) -> LobeWidth {
        let roughness = least_of_anisotropic(roughness, anisotropy);
        let width = 2.0 * widest_alpha(roughness, anisotropy);
        if roughness < LEAST_ROUGHNESS { LobeWidth::Specular } else { LobeWidth::of_width(width) }
    }
}

/// A roughness as kernels have it: microfacets with an anisotropy are never smooth.
pub fn least_of_anisotropic(roughness: f64, anisotropy: f64) -> f32 {
    if anisotropy > 0.0 { (roughness as f32).max(LEAST_ROUGHNESS) } else { roughness as f32 }
}

/// The largest alpha of microfacets of this roughness and anisotropy, as widest_alpha (shaders/lobe/anisotropy).
pub fn widest_alpha(roughness: f32, anisotropy: f64) -> f32 {
    let alpha = roughness * roughness;
    let along = (anisotropy as f32).powi(2);
    alpha + along * (1.0 - alpha)
}

/// The anisotropy of microfacets, and whether it may be less somewhere.
#[derive(Clone, Copy)]
pub struct Along {
    pub strength: f64,
    pub varies: bool,
}

impl Along {
    pub const NONE: Along = Along { strength: 0.0, varies: false };

    pub fn new(strength: f64, texture: &Option<Texture>) -> Along {
        Along { strength, varies: texture.is_some() }
    }
}

/// The widths of the lobes of microfacets, by those of a roughness and an anisotropy, for a roughness that may vary: as narrow as its least number
/// makes them, and wider.
pub fn widths_of_roughness(
    roughness: &Texture,
    along: Along,
    bitmaps: &Bitmaps,
    widths: impl Fn(f64, f64) -> Vec<LobeWidth>,
) -> Vec<LobeWidth> {
    let least = roughness.least(bitmaps);
    let narrowest = widths(least, if along.varies { 0.0 } else { along.strength });
    let varies = roughness.plain().is_none() || along.varies;
    let may_have = |width: &LobeWidth| narrowest.iter().any(|own| own == width || varies && own < width);
    [LobeWidth::Specular, LobeWidth::Narrow, LobeWidth::Wide].into_iter().filter(may_have).collect()
}

/// The widths of lobes that reflect by microfacets.
pub fn widths_of_facets(roughness: &Texture, along: Along, bitmaps: &Bitmaps) -> Vec<LobeWidth> {
    widths_of_roughness(roughness, along, bitmaps, |roughness, along| vec![LobeWidth::of_facets(roughness, along)])
}

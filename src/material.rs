//! Materials: how surfaces scatter and emit light. Each material has one file here with all that the host needs of it,
//! and one file under shaders/material with the functions of the kernels.

mod conductor;
mod declared;
mod dielectric;
mod diffuse_light;
mod lambertian;
mod metal;
pub mod microfacets;
mod model;
mod pbr;
mod rough_dielectric;
pub mod sheen;
mod thin_dielectric;

use crate::bitmap::Bitmaps;
use crate::error::Result;
use crate::source::ValuePath;
use crate::source::form::{any_of, kinds};
use crate::texture::{Colour, Texture, Use};

use declared::is_zero;
pub use declared::{MOST_ABSORPTION, MOST_DISPERSION, MOST_IOR, MOST_THICKNESS, Material};
use model::{Along, Coat, Film, lobes_of_roughness};
pub use model::{
    Emission, Emitted, Extension, ExtensionKind, LEAST_ROUGHNESS, Lobe, MaterialKind, Model, NARROW_LOBE, Slot,
    Vertices,
};

kinds! {
    Material: MaterialKind;
    Lambertian => lambertian::KIND,
    Metal => metal::KIND,
    Dielectric => dielectric::KIND,
    DiffuseLight => diffuse_light::KIND,
    Conductor => conductor::KIND,
    RoughDielectric => rough_dielectric::KIND,
    Pbr => pbr::KIND,
    ThinDielectric => thin_dielectric::KIND,
}

impl Material {
    /// The properties of the material.
    pub fn model(&self) -> Model<'_> {
        match self {
            Material::Lambertian {
                albedo,
                emission,
                alpha,
                alpha_cutoff,
                vertex_colors,
                vertex_alpha,
                vertex_emission,
                normal,
                normal_scale,
            } => {
                let model = lambertian::model(albedo).emissive(emission).cut_out(alpha, *alpha_cutoff, *vertex_alpha);
                let model = model.coloured_by_vertices(*vertex_colors).emissive_by_vertices(*vertex_emission);
                model.bumped(normal, *normal_scale)
            }
            Material::Metal { albedo, fuzz } => metal::model(albedo, *fuzz),
            Material::Dielectric { ior, transmittance, absorption, dispersion } => {
                dielectric::model(*ior).tinted(transmittance).absorbing(*absorption).dispersing(*ior, *dispersion)
            }
            Material::DiffuseLight { emit, two_sided } => diffuse_light::model(emit, *two_sided),
            Material::Conductor {
                albedo,
                eta,
                k,
                roughness,
                multiscatter,
                anisotropy,
                anisotropy_rotation,
                anisotropy_texture,
                normal,
                normal_scale,
            } => {
                let model = conductor::model(albedo.as_ref(), *eta, *k, roughness);
                let model = model.scattering_many_times(*multiscatter).bumped(normal, *normal_scale);
                model.anisotropic(*anisotropy, *anisotropy_rotation, anisotropy_texture)
            }
            Material::RoughDielectric {
                ior,
                roughness,
                transmittance,
                absorption,
                dispersion,
                anisotropy,
                anisotropy_rotation,
                anisotropy_texture,
                normal,
                normal_scale,
            } => {
                let model = rough_dielectric::model(*ior, roughness).dispersing(*ior, *dispersion);
                let model = model.tinted(transmittance).absorbing(*absorption).bumped(normal, *normal_scale);
                model.anisotropic(*anisotropy, *anisotropy_rotation, anisotropy_texture)
            }
            Material::ThinDielectric { ior, roughness, transmittance, normal, normal_scale } => {
                thin_dielectric::model(*ior, roughness).tinted(transmittance).bumped(normal, *normal_scale)
            }
            Material::Pbr {
                base_color,
                metallic,
                roughness,
                ior,
                specular,
                specular_color,
                transmission,
                solid,
                absorption,
                dispersion,
                diffuse_transmission,
                diffuse_transmission_color,
                iridescence,
                iridescence_ior,
                iridescence_thickness,
                iridescence_thickness_min,
                iridescence_thickness_texture,
                coat,
                coat_roughness,
                coat_ior,
                coat_normal,
                coat_normal_scale,
                sheen,
                sheen_roughness,
                multiscatter,
                emission,
                alpha,
                alpha_cutoff,
                vertex_colors,
                vertex_alpha,
                anisotropy,
                anisotropy_rotation,
                anisotropy_texture,
                normal,
                normal_scale,
            } => {
                let model = pbr::model(base_color, metallic, roughness, *ior).emissive(emission);
                let model = model.cut_out(alpha, *alpha_cutoff, *vertex_alpha).coloured_by_vertices(*vertex_colors);
                let model = model.scattering_many_times(*multiscatter).bumped(normal, *normal_scale);
                let model = model.layered(specular, specular_color, !is_zero(iridescence)).transmitting(
                    transmission,
                    &dielectric::model(*ior).on_device,
                    *solid,
                );
                let coat = Coat {
                    share: coat,
                    roughness: coat_roughness,
                    ior: *coat_ior,
                    normal: coat_normal,
                    normal_scale: *coat_normal_scale,
                };
                let model = model.coated(coat).sheened(sheen, sheen_roughness);
                let film = Film {
                    share: iridescence,
                    ior: *iridescence_ior,
                    thickness: iridescence_thickness_texture,
                    least: *iridescence_thickness_min,
                    most: *iridescence_thickness,
                };
                let model = model.filmed(film).translucent(diffuse_transmission, diffuse_transmission_color);
                let model = model.anisotropic(*anisotropy, *anisotropy_rotation, anisotropy_texture);
                let has_inside = *solid && !is_zero(transmission);
                let model = model.dispersing(*ior, if has_inside { *dispersion } else { 0.0 });
                let lacks = (absorption.is_some() && !has_inside)
                    .then_some("no absorption without `solid: true` and a transmission: it is of the inside of a body");
                let disperses_nothing = (*dispersion != 0.0 && !has_inside).then_some(
                    "no dispersion without `solid: true` and a transmission: it is of light that a body bends",
                );
                Model { lacks: lacks.or(disperses_nothing), ..model.absorbing(*absorption) }
            }
        }
    }

    /// The material as kernels have it, on objects whose vertices have these attributes. Neutral values are left out.
    pub fn model_on_device(&self, vertices: Vertices) -> Model<'_> {
        let model = match self {
            Material::RoughDielectric { ior, transmittance, absorption, dispersion, .. } if self.is_smooth_glass() => {
                dielectric::model(*ior).tinted(transmittance).absorbing(*absorption).dispersing(*ior, *dispersion)
            }
            _ => self.model(),
        };
        let metallic = match self {
            Material::Pbr { metallic, .. } => metallic.plain().map(|metallic| metallic.x),
            _ => None,
        };
        model.without_neutral(vertices, metallic)
    }

    /// The index of the kind that kernels know it as: a rough glass that is smooth is a `Dielectric`.
    pub fn number_on_device(&self) -> usize {
        let is_dielectric = |kind: &MaterialKind| kind.shader == dielectric::KIND.shader;
        let smooth = Material::KINDS.iter().position(is_dielectric).filter(|_| self.is_smooth_glass());
        smooth.unwrap_or_else(|| self.number())
    }

    fn is_smooth_glass(&self) -> bool {
        let Material::RoughDielectric { ior, roughness, anisotropy, normal, normal_scale, .. } = self else {
            return false;
        };
        let is_smooth = |roughness: Colour| rough_dielectric::lobes(*ior, roughness.x, *anisotropy) == [Lobe::Specular];
        roughness.plain().is_some_and(is_smooth) && (normal.is_none() || *normal_scale == 0.0)
    }

    /// Whether light passes it.
    pub fn is_transmissive(&self) -> bool {
        let passes = [ExtensionKind::Transmission, ExtensionKind::DiffuseTransmission];
        self.kind().is_transmissive || passes.into_iter().any(|kind| self.has_extension(kind))
    }

    pub fn has_extension(&self, kind: ExtensionKind) -> bool {
        self.model().has(kind)
    }

    /// Its lobes, which may be several. Where its roughness varies, they are as narrow as its least roughness makes them, and wider.
    pub fn lobes(&self, bitmaps: &Bitmaps) -> Vec<Lobe> {
        match self {
            Material::Conductor { roughness, anisotropy, anisotropy_texture, .. } => {
                let along = Along::new(*anisotropy, anisotropy_texture);
                lobes_of_roughness(roughness, along, bitmaps, |roughness, along| {
                    vec![conductor::lobe(roughness, along)]
                })
            }
            Material::RoughDielectric { ior, roughness, anisotropy, anisotropy_texture, .. } => {
                let along = Along::new(*anisotropy, anisotropy_texture);
                lobes_of_roughness(roughness, along, bitmaps, |roughness, along| {
                    rough_dielectric::lobes(*ior, roughness, along)
                })
            }
            Material::ThinDielectric { roughness, .. } => {
                lobes_of_roughness(roughness, Along::NONE, bitmaps, |roughness, _| {
                    vec![conductor::lobe(roughness, 0.0)]
                })
            }
            Material::Pbr {
                metallic,
                roughness,
                ior,
                transmission,
                solid,
                coat,
                coat_roughness,
                sheen,
                anisotropy,
                anisotropy_texture,
                ..
            } => {
                let along = Along::new(*anisotropy, anisotropy_texture);
                let (ior, is_solid) = (*ior, *solid);
                let parts =
                    pbr::Parts { metallic, roughness, along, ior, transmission, is_solid, coat, coat_roughness, sheen };
                pbr::lobes(&parts, bitmaps)
            }
            _ => self.model().lobes,
        }
    }

    /// Its textures that are no plain colour: its own, and those of its extensions.
    pub fn textures(&self) -> Vec<&Texture> {
        self.model().slots().filter(Slot::is_textured).map(|slot| slot.texture).collect()
    }

    /// Refuses invalid values; `at` is the path of the material.
    pub fn check(&self, at: &ValuePath) -> Result<()> {
        let at = at.variant(self.name());
        let model = self.model();
        // A plain number is checked as a field.
        let is_texture = |slot: &Slot| slot.usage != Use::Share || slot.is_textured();
        let mut textures = model.slots().filter(is_texture);
        textures.try_for_each(|slot| slot.texture.check(&at.field(slot.field.name), slot.usage))?;
        if let Some(expected) = model.lacks {
            return Err(at.unexpected(expected));
        }
        self.check_fields(&at).into_iter().next().map_or(Ok(()), Err)
    }

    /// Warnings about values that are allowed but likely to disappoint.
    pub fn warnings(&self, at: &ValuePath, bitmaps: &Bitmaps) -> Vec<String> {
        let at = at.variant(self.name());
        let model = self.model();
        let of_number = model.warning.iter().map(|(field, warning)| at.field(field.name).warning(warning));
        of_number.chain(model.slots().filter_map(|slot| slot.warning(&at, bitmaps))).collect()
    }
}

/// The shader files of the kinds of material, under shaders/material. Kernels switch on the indices.
pub const MATERIALS: &[&str] = Material::SHADERS;

/// The words in error messages for an expected material.
pub fn a_material() -> String {
    format!("a material: {}", any_of(Material::FORMS.iter()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_words_for_a_material_name_the_kinds() {
        let expected = a_material();
        assert!(expected.starts_with("a material: Lambertian(..), Metal(..), "), "{expected}");
        assert_eq!(expected.matches(" or ").count(), 1, "{expected}");
        assert_eq!(Material::FORMS[1].in_full(), "Metal(albedo: .., fuzz: ..)");
    }
}

//! Materials: how surfaces scatter and emit light. Each material has one file here with all that the host needs of it,
//! and one file under shaders/material with the functions of the kernels.

mod boundary;
mod conductor;
pub(crate) mod declared;
mod dielectric;
mod diffuse_light;
mod lambertian;
mod layer;
mod metal;
pub mod microfacets;
mod mix;
mod model;
mod pbr;
mod plastic;
mod rough_dielectric;
mod row;
mod thin_dielectric;
mod width;

use crate::bitmap::Bitmaps;
use crate::error::Result;
use crate::lobe::diffuse_transmission::DIFFUSE_TRANSMISSION;
use crate::lobe::transmission::TRANSMISSION;
use crate::source::ValuePath;
use crate::source::form::{any_of, kinds};
use crate::texture::{Texture, Use};

pub use boundary::{glass_numbers, widths_of_boundary};
pub use declared::{
    Conductor, Dielectric, DiffuseLight, Distribution, LIGHT_GROUP, Lambertian, MOST_ABSORPTION, MOST_DISPERSION,
    MOST_IOR, MOST_THICKNESS, Material, Metal, Mix, Pbr, Plastic, RoughDielectric, ThinDielectric, is_white, is_zero,
};
pub use model::{Emission, Emitted, MaterialKind, Model, Vertices, emission_row};
pub use row::{ALPHA, MIX, ROUGH_LAYER, ROUGHNESS, ROWS, Row, RowKind, Sets, Slot, VERTEX_COLOURS, varying};
pub use width::{Along, LEAST_ROUGHNESS, LobeWidth, widths_of_facets, widths_of_roughness};

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
    Plastic => plastic::KIND,
    Mix => mix::KIND,
}

impl Material {
    /// The properties of the material.
    pub fn model(&self) -> Model<'_> {
        match self {
            Material::Lambertian(own) => own.model(),
            Material::Metal(own) => own.model(),
            Material::Dielectric(own) => own.model(),
            Material::DiffuseLight(own) => own.model(),
            Material::Conductor(own) => own.model(),
            Material::RoughDielectric(own) => own.model(),
            Material::Pbr(own) => own.model(),
            Material::ThinDielectric(own) => own.model(),
            Material::Plastic(own) => own.model(),
            Material::Mix(own) => own.model(),
        }
    }

    /// The material as kernels have it, on objects whose vertices have these attributes. Neutral values are left out.
    pub fn model_on_device(&self, vertices: Vertices) -> Model<'_> {
        let model = match self {
            Material::RoughDielectric(own) if own.is_smooth() => own.as_smooth_glass(),
            Material::Pbr(own) => own.model_on_device(),
            _ => self.model(),
        };
        model.without_neutral(vertices)
    }

    /// The index of the kind that kernels know it as: a rough glass that is smooth is a `Dielectric`.
    pub fn number_on_device(&self) -> usize {
        let is_smooth_glass = matches!(self, Material::RoughDielectric(own) if own.is_smooth());
        let is_dielectric = |kind: &MaterialKind| kind.shader == dielectric::KIND.shader;
        let smooth = Material::KINDS.iter().position(is_dielectric).filter(|_| is_smooth_glass);
        smooth.unwrap_or_else(|| self.number())
    }

    /// The group of the light that it emits.
    pub fn light_group(&self) -> Option<&str> {
        match self {
            Material::Lambertian(own) => own.light_group.as_deref(),
            Material::DiffuseLight(own) => own.light_group.as_deref(),
            Material::Pbr(own) => own.light_group.as_deref(),
            Material::Plastic(own) => own.light_group.as_deref(),
            _ => None,
        }
    }

    /// Whether light passes it.
    pub fn is_transmissive(&self) -> bool {
        self.kind().is_transmissive || self.has_row(TRANSMISSION) || self.has_row(DIFFUSE_TRANSMISSION)
    }

    pub fn has_row(&self, kind: &RowKind) -> bool {
        self.model().has(kind)
    }

    /// The widths of its lobes. Where its roughness varies, they are as narrow as its least roughness makes them, and wider.
    pub fn widths(&self, bitmaps: &Bitmaps) -> Vec<LobeWidth> {
        match self {
            Material::Conductor(own) => own.widths(bitmaps),
            Material::RoughDielectric(own) => own.widths(bitmaps),
            Material::ThinDielectric(own) => own.widths(bitmaps),
            Material::Pbr(own) => own.widths(bitmaps),
            _ => self.model().widths,
        }
    }

    /// Its textures that are no plain colour: its own, and those of its rows.
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
    fn a_file_that_gives_nothing_has_the_default() {
        let read: Material = ron::from_str("Pbr()").expect("all fields have defaults");
        assert_eq!(read, Material::Pbr(Pbr::default()));
    }

    #[test]
    fn the_words_for_a_material_name_the_kinds() {
        let expected = a_material();
        assert!(expected.starts_with("a material: Lambertian(..), Metal(..), "), "{expected}");
        assert_eq!(expected.matches(" or ").count(), 1, "{expected}");
        assert_eq!(Material::FORMS[1].in_full(), "Metal(albedo: .., fuzz: .., one_sided: ..)");
    }
}

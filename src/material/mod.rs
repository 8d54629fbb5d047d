//! Materials: how surfaces scatter and emit light. Each material has one file here with all that the host needs of it,
//! and one file under shaders/material with the functions of the kernels.

mod dielectric;
mod diffuse_light;
mod lambertian;
mod metal;

use serde::Deserialize;

use crate::data;
use crate::error::Result;
use crate::source::Place;
use crate::source::form::{Form, any_of, kinds};
use crate::texture::{Bitmaps, Texture, Use};

/// A material as the scene file writes it.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Material {
    Lambertian {
        albedo: Texture,
    },
    Metal {
        albedo: Texture,
        #[serde(default)]
        fuzz: f64,
    },
    Dielectric {
        ior: f64,
    },
    DiffuseLight {
        emit: Texture,
        #[serde(default = "yes")]
        two_sided: bool,
    },
}

fn yes() -> bool {
    true
}

kinds! {
    Material: MaterialKind;
    Lambertian => lambertian::KIND,
    Metal => metal::KIND,
    Dielectric => dielectric::KIND,
    DiffuseLight => diffuse_light::KIND,
}

impl Material {
    /// The implementation of the material.
    pub fn model(&self) -> Box<dyn Model<'_> + '_> {
        match self {
            Material::Lambertian { albedo } => Box::new(lambertian::Lambertian { albedo }),
            Material::Metal { albedo, fuzz } => Box::new(metal::Metal { albedo, fuzz: *fuzz }),
            Material::Dielectric { ior } => Box::new(dielectric::Dielectric { ior: *ior }),
            Material::DiffuseLight { emit, two_sided } => {
                Box::new(diffuse_light::DiffuseLight { emit, two_sided: *two_sided })
            }
        }
    }

    /// Its textures, without plain colours.
    pub fn textures(&self) -> Vec<&Texture> {
        let textures = self.model().slots().into_iter().map(|slot| slot.texture);
        textures.filter(|texture| texture.plain().is_none()).collect()
    }

    /// Refuses invalid values; `at` is the place of the material.
    pub fn check(&self, at: &Place) -> Result<()> {
        let at = at.variant(self.name());
        let model = self.model();
        for slot in model.slots() {
            slot.texture.check(&at.field(slot.field), slot.usage)?;
        }
        model.check(&at)
    }

    /// Warnings about values that are allowed but likely to disappoint.
    pub fn warnings(&self, at: &Place, bitmaps: &Bitmaps) -> Vec<String> {
        let at = at.variant(self.name());
        let model = self.model();
        let of_slots = model.slots().into_iter().filter_map(|slot| slot.warning(&at, bitmaps));
        model.warning(&at).into_iter().chain(of_slots).collect()
    }
}

/// The shader files of the kinds of material, under shaders/material. Kernels switch on the indices.
pub const MATERIALS: &[&str] = Material::SHADERS;

/// The words in error messages for an expected material.
pub fn a_material() -> String {
    format!("a material: {}", any_of(Material::KINDS.iter().map(|kind| &kind.form)))
}

/// The properties that all materials of a kind share.
#[derive(Debug)]
pub struct MaterialKind {
    pub form: Form,
    /// The name of its file under shaders/material.
    pub shader: &'static str,
    /// The ways in which materials of the kind scatter. If one of them is `Spread`, a second file SHADER_eval evaluates
    /// the BSDF for light sampling.
    pub scatters: &'static [Scattering],
    /// Whether it transmits light.
    pub is_clear: bool,
    pub emits: bool,
}

/// How a material scatters light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scattering {
    /// Into many directions, so that lights can be sampled. On the device, SHADER_is_non_specular says whether a material does.
    Spread,
    /// Specular: into a single direction, so that paths find lights only by chance.
    OneWay,
    Nowhere,
}

/// What every material implements on the host. No method has a default, so that a new material cannot forget one.
pub trait Model<'a> {
    /// Its textures.
    fn slots(&self) -> Vec<Slot<'a>>;
    /// Refuses invalid numbers; textures are checked elsewhere. `at` is the place of the variant.
    fn check(&self, at: &Place) -> Result<()>;
    /// A warning about numbers that are allowed; warnings about textures are made elsewhere.
    fn warning(&self, at: &Place) -> Option<String>;
    fn scattering(&self) -> Scattering;
    fn emission(&self) -> Option<Emission<'a>>;
    /// The struct that kernels read. `paint` lays out a slot's texture. The number of the kind is filled in later.
    fn upload(&self, paint: &mut dyn FnMut(Slot<'a>) -> Paint) -> data::Material;
}

/// A texture of a material, with the name of the field that holds it.
#[derive(Clone, Copy, Debug)]
pub struct Slot<'a> {
    pub field: &'static str,
    pub usage: Use,
    pub texture: &'a Texture,
}

/// A slot as kernels read it.
#[derive(Clone, Copy, Debug)]
pub struct Paint {
    /// The colour, if it is the same everywhere.
    pub colour: [f32; 3],
    /// The number of the texture, or `NO_TEXTURE`.
    pub texture: u32,
}

/// The emission of a material.
#[derive(Clone, Copy, Debug)]
pub struct Emission<'a> {
    pub slot: Slot<'a>,
    pub two_sided: bool,
}

impl<'a> Slot<'a> {
    fn albedo(texture: &'a Texture) -> Slot<'a> {
        Slot { field: "albedo", usage: Use::Albedo, texture }
    }

    fn warning(&self, at: &Place, bitmaps: &Bitmaps) -> Option<String> {
        let (is_odd, message) = match self.usage {
            Use::Albedo => (
                self.texture.is_white(bitmaps),
                "an albedo of 1 absorbs nothing, so that paths in a closed scene end only at max_depth: write 0.99 or less unless that \
                 is intended",
            ),
            Use::Radiance => (
                self.texture.brightest(bitmaps) == 0.0,
                "an emission of 0 emits no light: raise it, or write Lambertian(albedo: Rgb(0, 0, 0)) for a black surface",
            ),
        };
        is_odd.then(|| at.field(self.field).warning(message))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_expected_names_the_kinds() {
        let expected = a_material();
        assert!(expected.starts_with("a material: Lambertian(..), Metal(..), "), "{expected}");
        assert_eq!(expected.matches(" or ").count(), 1, "{expected}");
        assert_eq!(metal::KIND.form.in_full(), "Metal(albedo: .., fuzz: ..)");
    }
}

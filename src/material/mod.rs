//! Materials: how surfaces scatter and emit light. Each material has one file here with all that the host needs of it,
//! and one file under shaders/material with the functions of the kernels.

mod conductor;
mod dielectric;
mod diffuse_light;
mod lambertian;
mod metal;
mod pbr;
mod rough_dielectric;

use serde::{Deserialize, Serialize};

use crate::bitmap::Bitmaps;
use crate::data;
use crate::error::Result;
use crate::source::form::{Field, Form, NO_UNIT, Takes, any_of, kinds};
use crate::source::{Place, Range};
use crate::texture::{Colour, Texture, Use, number};

/// A material as the scene file writes it.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Material {
    Lambertian {
        albedo: Texture,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        emission: Option<Texture>,
        #[serde(default = "white", with = "number", skip_serializing_if = "is_white")]
        alpha: Texture,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        alpha_cutoff: Option<f64>,
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        vertex_colors: bool,
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
    Conductor {
        #[serde(default, skip_serializing_if = "Option::is_none")]
        albedo: Option<Texture>,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        eta: Option<Colour>,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        k: Option<Colour>,
        #[serde(default = "zero", with = "number")]
        roughness: Texture,
    },
    RoughDielectric {
        ior: f64,
        #[serde(default = "zero", with = "number")]
        roughness: Texture,
    },
    Pbr {
        #[serde(default = "white")]
        base_color: Texture,
        #[serde(default = "white", with = "number")]
        metallic: Texture,
        #[serde(default = "white", with = "number")]
        roughness: Texture,
        #[serde(default = "index_of_glass")]
        ior: f64,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        emission: Option<Texture>,
        #[serde(default = "white", with = "number", skip_serializing_if = "is_white")]
        alpha: Texture,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        alpha_cutoff: Option<f64>,
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        vertex_colors: bool,
    },
}

fn yes() -> bool {
    true
}

fn white() -> Texture {
    Texture::Rgb(1.0, 1.0, 1.0)
}

fn is_white(texture: &Texture) -> bool {
    *texture == white()
}

fn zero() -> Texture {
    Texture::grey(0.0)
}

fn index_of_glass() -> f64 {
    1.5
}

kinds! {
    Material: MaterialKind;
    Lambertian => lambertian::KIND,
    Metal => metal::KIND,
    Dielectric => dielectric::KIND,
    DiffuseLight => diffuse_light::KIND,
    Conductor => conductor::KIND,
    RoughDielectric => rough_dielectric::KIND,
    Pbr => pbr::KIND,
}

impl Material {
    /// The properties of the material.
    pub fn model(&self) -> Model<'_> {
        match self {
            Material::Lambertian { albedo, emission, alpha, alpha_cutoff, vertex_colors } => {
                let alpha = Alpha { alpha, cutoff: *alpha_cutoff };
                lambertian::model(albedo, emission.as_ref(), alpha, *vertex_colors)
            }
            Material::Metal { albedo, fuzz } => metal::model(albedo, *fuzz),
            Material::Dielectric { ior } => dielectric::model(*ior),
            Material::DiffuseLight { emit, two_sided } => diffuse_light::model(emit, *two_sided),
            Material::Conductor { albedo, eta, k, roughness } => conductor::model(albedo.as_ref(), *eta, *k, roughness),
            Material::RoughDielectric { ior, roughness } => rough_dielectric::model(*ior, roughness),
            Material::Pbr { base_color, metallic, roughness, ior, emission, alpha, alpha_cutoff, vertex_colors } => {
                let alpha = Alpha { alpha, cutoff: *alpha_cutoff };
                pbr::model(base_color, metallic, roughness, *ior, emission.as_ref(), alpha, *vertex_colors)
            }
        }
    }

    /// Whether it lets light pass straight on somewhere.
    pub fn has_alpha(&self) -> bool {
        self.model().details.iter().any(|detail| detail.kind == DetailKind::Alpha)
    }

    /// The ways in which it scatters. Where its roughness varies, it may be smooth in some places.
    pub fn scatterings(&self, bitmaps: &Bitmaps) -> Vec<Scattering> {
        let model = self.model();
        let of_roughness = model.details.iter().find(|detail| detail.kind == DetailKind::Roughness);
        let Some(detail) = of_roughness else { return vec![model.scattering] };
        let least = detail.slot.texture.least(bitmaps);
        let smoothest = match self {
            Material::Conductor { .. } => conductor::scattering(least),
            Material::RoughDielectric { ior, .. } => rough_dielectric::scattering(*ior, least),
            _ => model.scattering,
        };
        if smoothest == Scattering::Spread { vec![smoothest] } else { vec![Scattering::Spread, smoothest] }
    }

    /// Its textures that are no plain colour: its own, and those of its details.
    pub fn textures(&self) -> Vec<&Texture> {
        self.model().slots().map(|slot| slot.texture).filter(|texture| texture.plain().is_none()).collect()
    }

    /// Refuses invalid values; `at` is the place of the material.
    pub fn check(&self, at: &Place) -> Result<()> {
        let at = at.variant(self.name());
        let model = self.model();
        // A plain number is among the numbers.
        let is_texture = |slot: &Slot| slot.usage != Use::Share || slot.texture.plain().is_none();
        let mut textures = model.slots().filter(is_texture);
        textures.try_for_each(|slot| slot.texture.check(&at.field(slot.field.name), slot.usage))?;
        if let Some(expected) = model.lacks {
            return Err(at.unexpected(expected));
        }
        model.colours.iter().try_for_each(|(field, colour)| field.check_colour(&at, *colour))?;
        model.numbers.iter().try_for_each(|number| number.field.check(&at, number.value))
    }

    /// Warnings about values that are allowed but likely to disappoint.
    pub fn warnings(&self, at: &Place, bitmaps: &Bitmaps) -> Vec<String> {
        let at = at.variant(self.name());
        let model = self.model();
        let of_numbers = model
            .numbers
            .iter()
            .filter_map(|number| Some(at.field(number.field.name).warning(number.warning.as_ref()?)));
        of_numbers.chain(model.slots().filter_map(|slot| slot.warning(&at, bitmaps))).collect()
    }
}

/// The shader files of the kinds of material, under shaders/material. Kernels switch on the indices.
pub const MATERIALS: &[&str] = Material::SHADERS;

/// A roughness below this makes a smooth surface, as shaders/lib/microfacet says.
pub const LEAST_ROUGHNESS: f32 = 1.0 / 1024.0;

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
    /// What materials of the kind may have beside their row of the table.
    pub details: &'static [DetailKind],
    /// Whether kernels read more numbers of it than one element of their table holds. Then it has two of them.
    pub has_second_part: bool,
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

/// The properties of a material on the host. No field has a default, so that a new material cannot forget one.
pub struct Model<'a> {
    /// Its texture, if it has one.
    pub slot: Option<Slot<'a>>,
    pub scattering: Scattering,
    /// Whether it emits to both sides; none if it does not emit. Its texture is the emitted radiance.
    pub two_sided: Option<bool>,
    pub numbers: Vec<Number>,
    /// Colours that are no textures, each with the field that holds it.
    pub colours: Vec<(&'static Field, Colour)>,
    /// What is expected, if fields that exclude or require each other are not given so.
    pub lacks: Option<&'static str>,
    /// What it has beside its row of the table.
    pub details: Vec<Detail<'a>>,
    /// The struct that kernels read. The texture and the number of the kind are filled in later.
    pub on_device: data::Material,
    /// The same of its second part, if its kind has one.
    pub second_part: Option<data::Material>,
}

/// A number of a material, with the field that holds it.
pub struct Number {
    pub field: &'static Field,
    pub value: f64,
    /// A warning about a value that is allowed but likely to disappoint.
    pub warning: Option<String>,
}

/// A texture of a material, with the field that holds it.
#[derive(Clone, Copy, Debug)]
pub struct Slot<'a> {
    pub field: &'static Field,
    pub usage: Use,
    pub texture: &'a Texture,
}

/// What a material may have beside its row of the table: a row of its own for each (shaders/data/material).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DetailKind {
    /// The radiance that it emits beside what it scatters.
    Emission,
    /// The share of light that it stops.
    Alpha,
    /// Factors of its numbers.
    Roughness,
    Metallic,
    /// The normal in the frame of the texture coordinates.
    Normal,
    /// The colours of a mesh's vertices, which multiply its own.
    VertexColours,
}

impl DetailKind {
    /// The index of the row with a material's detail of this kind.
    pub fn row_of(self, details: &mut data::Detail) -> &mut u32 {
        match self {
            DetailKind::Emission => &mut details.emission,
            DetailKind::Alpha => &mut details.alpha,
            DetailKind::Roughness => &mut details.roughness,
            DetailKind::Metallic => &mut details.metallic,
            DetailKind::Normal => &mut details.normal,
            DetailKind::VertexColours => &mut details.vertex_colours,
        }
    }
}

/// The number of kinds of detail.
pub const DETAILS: usize = DetailKind::VertexColours as usize + 1;

/// One of them.
#[derive(Clone, Copy, Debug)]
pub struct Detail<'a> {
    pub kind: DetailKind,
    pub slot: Slot<'a>,
    /// The number beside its texture. Emission: 1 if it emits to both sides, else 0. Alpha: its cutoff, or -1.
    pub parameter: f32,
}

const EMISSION: Field = Field::new(
    "emission",
    Takes::Texture(Use::Radiance.range()),
    "The radiance that it emits beside what it reflects, on both sides.",
)
.or("none: it emits nothing");

/// What a material emits beside what it scatters.
fn glow(emission: Option<&Texture>) -> Option<Detail<'_>> {
    Some(Detail::emission(Slot { field: &EMISSION, usage: Use::Radiance, texture: emission? }, true))
}

const ALPHA: Field = Field::new(
    "alpha",
    Takes::Varying(Range::SHARE),
    "The share of light that it stops; the rest passes straight on, as if the surface were not there. For quads and meshes.",
)
.or("1");
const ALPHA_CUTOFF: Field = Field::new(
    "alpha_cutoff",
    Takes::Number(Range::NOT_NEGATIVE, NO_UNIT),
    "With it, the surface stops all light where its alpha is at least this, and none elsewhere.",
)
.or("no cutoff");

const VERTEX_COLORS: Field = Field::new(
    "vertex_colors",
    Takes::Other("true or false"),
    "Whether the colours of a mesh's vertices multiply its colour. Those of glTF files are read (`COLOR_0`, without its alpha).",
)
.or("false");

/// What tells that it has vertex colours. They lie in the mesh, so the row is white.
fn vertex_colours(has_them: bool) -> Option<Detail<'static>> {
    static WHITE: Texture = Texture::Rgb(1.0, 1.0, 1.0);
    let slot = Slot { field: &VERTEX_COLORS, usage: Use::Share, texture: &WHITE };
    has_them.then_some(Detail { kind: DetailKind::VertexColours, slot, parameter: 0.0 })
}

/// How much of the light a material stops.
struct Alpha<'a> {
    alpha: &'a Texture,
    cutoff: Option<f64>,
}

impl<'a> Alpha<'a> {
    /// Nothing if it stops all light everywhere.
    fn detail(&self) -> Option<Detail<'a>> {
        let least = self.cutoff.unwrap_or(1.0);
        let stops_all = self.alpha.plain().is_some_and(|alpha| alpha.x >= least);
        let slot = Slot { field: &ALPHA, usage: Use::Share, texture: self.alpha };
        let detail =
            Detail { kind: DetailKind::Alpha, slot, parameter: self.cutoff.map_or(-1.0, |cutoff| cutoff as f32) };
        (!stops_all).then_some(detail)
    }

    /// Its numbers, to be checked.
    fn numbers(&self) -> impl Iterator<Item = Number> {
        let alpha = self.alpha.plain().map(|alpha| (&ALPHA, alpha.x));
        let cutoff = self.cutoff.map(|cutoff| (&ALPHA_CUTOFF, cutoff));
        alpha.into_iter().chain(cutoff).map(|(field, value)| Number { field, value, warning: None })
    }
}

impl<'a> Detail<'a> {
    pub fn emission(slot: Slot<'a>, two_sided: bool) -> Detail<'a> {
        Detail { kind: DetailKind::Emission, slot, parameter: f32::from(u8::from(two_sided)) }
    }
}

/// A material's number that may vary: the number, or 0 and the detail that stands for it.
fn varying<'a>(
    field: &'static Field,
    kind: DetailKind,
    texture: &'a Texture,
) -> (f64, Option<Number>, Option<Detail<'a>>) {
    match texture.plain() {
        Some(grey) => (grey.x, Some(Number { field, value: grey.x, warning: None }), None),
        None => {
            let slot = Slot { field, usage: Use::Share, texture };
            (0.0, None, Some(Detail { kind, slot, parameter: 0.0 }))
        }
    }
}

/// The emission of a material.
#[derive(Clone, Copy, Debug)]
pub struct Emission<'a> {
    pub slot: Slot<'a>,
    pub two_sided: bool,
}

impl<'a> Model<'a> {
    /// What it emits, if it does not scatter.
    pub fn light(&self) -> Option<Emission<'a>> {
        Some(Emission { slot: self.slot?, two_sided: self.two_sided? })
    }

    /// What it emits, whether it scatters or not.
    pub fn emission(&self) -> Option<Emission<'a>> {
        let glow = || self.details.iter().find(|detail| detail.kind == DetailKind::Emission);
        self.light().or_else(|| {
            let Detail { slot, parameter, .. } = *glow()?;
            Some(Emission { slot, two_sided: parameter != 0.0 })
        })
    }

    /// Its textures, also plain ones: its own first, then those of its details in their order.
    pub fn slots(&self) -> impl Iterator<Item = Slot<'a>> + use<'a, '_> {
        self.slot.into_iter().chain(self.details.iter().map(|detail| detail.slot))
    }
}

impl Slot<'_> {
    fn warning(&self, at: &Place, bitmaps: &Bitmaps) -> Option<String> {
        let (is_odd, message) = match self.usage {
            Use::Albedo => (
                self.texture.is_white(bitmaps),
                "an albedo of 1 absorbs nothing, so that paths in a closed scene end only at max_depth: write 0.99 or less unless that \
                 is intended",
            ),
            Use::Share => return None,
            Use::Radiance => (
                self.texture.brightest(bitmaps) == 0.0,
                "an emission of 0 emits no light: raise it, or write Lambertian(albedo: Rgb(0, 0, 0)) for a black surface",
            ),
        };
        is_odd.then(|| at.field(self.field.name).warning(message))
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

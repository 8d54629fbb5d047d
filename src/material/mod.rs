//! Materials: how surfaces scatter and emit light. Each material has one file here with all that the host needs of it,
//! and one file under shaders/material with the functions of the kernels.

mod conductor;
mod dielectric;
mod diffuse_light;
mod lambertian;
mod metal;
pub mod microfacets;
mod pbr;
mod rough_dielectric;
mod thin_dielectric;

use serde::{Deserialize, Serialize};

use crate::bitmap::Bitmaps;
use crate::data;
use crate::error::Result;
use crate::source::form::{Field, Form, Takes, any_of, kinds};
use crate::source::{NO_UNIT, Place, Range};
use crate::texture::{Colour, Texture, Use, normal_map, number};

/// A material as the scene file writes it.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[expect(clippy::large_enum_variant, reason = "a scene has few materials")]
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
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        vertex_alpha: bool,
        #[serde(default, deserialize_with = "normal_map::deserialize", skip_serializing_if = "Option::is_none")]
        normal: Option<Texture>,
        #[serde(default = "one", skip_serializing_if = "is_one")]
        normal_scale: f64,
    },
    Metal {
        albedo: Texture,
        #[serde(default)]
        fuzz: f64,
    },
    Dielectric {
        ior: f64,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        transmittance: Option<Texture>,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        absorption: Option<Colour>,
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
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        multiscatter: bool,
        #[serde(default, deserialize_with = "normal_map::deserialize", skip_serializing_if = "Option::is_none")]
        normal: Option<Texture>,
        #[serde(default = "one", skip_serializing_if = "is_one")]
        normal_scale: f64,
    },
    RoughDielectric {
        ior: f64,
        #[serde(default = "zero", with = "number")]
        roughness: Texture,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        transmittance: Option<Texture>,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        absorption: Option<Colour>,
        #[serde(default, deserialize_with = "normal_map::deserialize", skip_serializing_if = "Option::is_none")]
        normal: Option<Texture>,
        #[serde(default = "one", skip_serializing_if = "is_one")]
        normal_scale: f64,
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
        #[serde(default = "one", skip_serializing_if = "is_one")]
        specular: f64,
        #[serde(default = "white", skip_serializing_if = "is_white")]
        specular_color: Texture,
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        multiscatter: bool,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        emission: Option<Texture>,
        #[serde(default = "white", with = "number", skip_serializing_if = "is_white")]
        alpha: Texture,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        alpha_cutoff: Option<f64>,
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        vertex_colors: bool,
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        vertex_alpha: bool,
        #[serde(default, deserialize_with = "normal_map::deserialize", skip_serializing_if = "Option::is_none")]
        normal: Option<Texture>,
        #[serde(default = "one", skip_serializing_if = "is_one")]
        normal_scale: f64,
    },
    ThinDielectric {
        #[serde(default = "index_of_glass")]
        ior: f64,
        #[serde(default = "zero", with = "number")]
        roughness: Texture,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        transmittance: Option<Texture>,
        #[serde(default, deserialize_with = "normal_map::deserialize", skip_serializing_if = "Option::is_none")]
        normal: Option<Texture>,
        #[serde(default = "one", skip_serializing_if = "is_one")]
        normal_scale: f64,
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

fn one() -> f64 {
    1.0
}

fn is_one(number: &f64) -> bool {
    *number == 1.0
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
                normal,
                normal_scale,
            } => {
                let model = lambertian::model(albedo).glowing(emission).cut_out(alpha, *alpha_cutoff, *vertex_alpha);
                model.coloured_by_vertices(*vertex_colors).bumped(normal, *normal_scale)
            }
            Material::Metal { albedo, fuzz } => metal::model(albedo, *fuzz),
            Material::Dielectric { ior, transmittance, absorption } => {
                dielectric::model(*ior).tinted(transmittance).absorbing(*absorption)
            }
            Material::DiffuseLight { emit, two_sided } => diffuse_light::model(emit, *two_sided),
            Material::Conductor { albedo, eta, k, roughness, multiscatter, normal, normal_scale } => {
                let model = conductor::model(albedo.as_ref(), *eta, *k, roughness);
                model.scattering_many_times(*multiscatter).bumped(normal, *normal_scale)
            }
            Material::RoughDielectric { ior, roughness, transmittance, absorption, normal, normal_scale } => {
                let model = rough_dielectric::model(*ior, roughness);
                model.tinted(transmittance).absorbing(*absorption).bumped(normal, *normal_scale)
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
                multiscatter,
                emission,
                alpha,
                alpha_cutoff,
                vertex_colors,
                vertex_alpha,
                normal,
                normal_scale,
            } => {
                let model = pbr::model(base_color, metallic, roughness, *ior).glowing(emission);
                let model = model.cut_out(alpha, *alpha_cutoff, *vertex_alpha).coloured_by_vertices(*vertex_colors);
                let model = model.scattering_many_times(*multiscatter).bumped(normal, *normal_scale);
                model.layered(*specular, specular_color)
            }
        }
    }

    /// Whether it lets light pass straight on somewhere.
    pub fn has_alpha(&self) -> bool {
        self.model().extensions.iter().any(|extension| extension.kind == ExtensionKind::Alpha)
    }

    /// Its lobes, which may be several. Where its roughness varies, they are as narrow as its least roughness makes them, and wider.
    pub fn lobes(&self, bitmaps: &Bitmaps) -> Vec<Lobe> {
        let model = self.model();
        let of_roughness = model.extensions.iter().find(|extension| extension.kind == ExtensionKind::Roughness);
        let Some(extension) = of_roughness else { return model.lobes };
        let least = extension.slot.texture.least(bitmaps);
        let narrowest = match self {
            Material::RoughDielectric { ior, .. } => rough_dielectric::lobes(*ior, least),
            _ => vec![conductor::lobe(least)],
        };
        [Lobe::Specular, Lobe::Narrow, Lobe::Wide]
            .into_iter()
            .filter(|lobe| narrowest.iter().any(|least| least <= lobe))
            .collect()
    }

    /// Its textures that are no plain colour: its own, and those of its extensions.
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
    /// The lobes that materials of the kind can have. If one of them is not specular, a second file SHADER_eval evaluates the BSDF for
    /// light sampling.
    pub lobes: &'static [Lobe],
    /// Whether it transmits light.
    pub is_transmissive: bool,
    pub emits: bool,
    /// What materials of the kind may have beside their row of the table.
    pub extensions: &'static [ExtensionKind],
    /// Whether kernels read more numbers of it than one element of their table holds. Then it has two of them.
    pub has_second_part: bool,
}

/// The width of a lobe into which a material scatters. On the device, SHADER_is_non_specular says whether a material has one that is not
/// specular.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Lobe {
    /// A single direction, for which no light can be sampled.
    Specular,
    /// Below [`NARROW_LOBE`], so that light sampling rarely finds a light in it.
    Narrow,
    Wide,
}

/// The width in radians from which on a lobe is wide, as shaders/data/material.wgsl says.
pub const NARROW_LOBE: f32 = 0.1;

impl Lobe {
    /// A lobe of this width in radians.
    pub fn of_width(width: f32) -> Lobe {
        if width < NARROW_LOBE { Lobe::Narrow } else { Lobe::Wide }
    }
}

/// The lobes of a kind of material whose roughness is a parameter.
const ANY_LOBE: &[Lobe] = &[Lobe::Wide, Lobe::Narrow, Lobe::Specular];

/// The properties of a material on the host. No field has a default, so that a new material cannot forget one.
pub struct Model<'a> {
    /// Its texture, if it has one.
    pub slot: Option<Slot<'a>>,
    /// None if it does not scatter. Those of a roughness of 0 where the roughness is a texture.
    pub lobes: Vec<Lobe>,
    /// Whether it emits to both sides; none if it does not emit. Its texture is the emitted radiance.
    pub two_sided: Option<bool>,
    pub numbers: Vec<Number>,
    /// Colours that are no textures, each with the field that holds it.
    pub colours: Vec<(&'static Field, Colour)>,
    /// What is expected, if fields that exclude or require each other are not given so.
    pub lacks: Option<&'static str>,
    /// What it has beside its row of the table.
    pub extensions: Vec<Extension<'a>>,
    /// Of a clear solid: what it absorbs per scene unit.
    pub absorption: Option<Colour>,
    /// The struct that kernels read. The texture and the number of the kind are filled in later.
    pub on_device: data::Material,
    /// The second part as kernels read it, if the kind has one.
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
pub enum ExtensionKind {
    /// The radiance that it emits beside what it scatters.
    Emission,
    /// The share of light that it stops.
    Alpha,
    /// Its roughness, where that varies over the surface.
    Roughness,
    /// How metallic it is, where that varies.
    Metallic,
    /// The normal in the frame of the texture coordinates.
    Normal,
    /// The colours of a mesh's vertices, which multiply its own.
    VertexColours,
    /// It makes up for light that microfacets scatter more than once.
    Multiscatter,
    /// How much the layer of glTF's material reflects, and in which colour.
    Specular,
    /// The alpha of a mesh's vertices, which multiplies its own.
    VertexAlpha,
}

impl ExtensionKind {
    /// The index of the row with a material's extension of this kind.
    pub fn row_of(self, extensions: &mut data::Extension) -> &mut u32 {
        match self {
            ExtensionKind::Emission => &mut extensions.emission,
            ExtensionKind::Alpha => &mut extensions.alpha,
            ExtensionKind::Roughness => &mut extensions.roughness,
            ExtensionKind::Metallic => &mut extensions.metallic,
            ExtensionKind::Normal => &mut extensions.normal,
            ExtensionKind::VertexColours => &mut extensions.vertex_colours,
            ExtensionKind::Multiscatter => &mut extensions.multiscatter,
            ExtensionKind::Specular => &mut extensions.specular,
            ExtensionKind::VertexAlpha => &mut extensions.vertex_alpha,
        }
    }
}

/// The number of kinds of extension.
pub const EXTENSIONS: usize = ExtensionKind::VertexAlpha as usize + 1;

/// An extension of a material, with its texture.
#[derive(Clone, Copy, Debug)]
pub struct Extension<'a> {
    pub kind: ExtensionKind,
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

const TRANSMITTANCE: Field = Field::new(
    "transmittance",
    Takes::Texture(Use::Albedo.range()),
    "The share of the refracted light that each surface lets pass. Light through a body passes two surfaces.",
)
.or("all of it");
/// The largest index of refraction of a surface that reflects from microfacets.
pub const MOST_IOR: f64 = 1e3;
/// The most that a clear solid absorbs per unit.
pub const MOST_ABSORPTION: f64 = 1e9;
const ABSORPTION: Field = Field::new(
    "absorption",
    Takes::Colour(Range::from_to(0.0, MOST_ABSORPTION)),
    "What the inside absorbs per scene unit: exp(-absorption · distance) is left of light that reaches the body's surface from inside. The \
     surface must be closed. Light that ends on another object inside the body keeps all.",
)
.or("none: it is clear");

const NORMAL: Field = Field::new(
    "normal",
    Takes::Other("an image: Image(path: ..)"),
    "A normal map: an image whose red, green and blue are the x, y and z of the normal, each from -1 at 0 to 1 at its largest code. x is \
     along u, y along v, and z is the normal of the surface. Its codes are linear.",
)
.or("none: the normal is that of the surface");
const NORMAL_SCALE: Field = Field::new(
    "normal_scale",
    Takes::Number(Range::from_to(-1e3, 1e3), NO_UNIT),
    "What x and y of the normal map are multiplied by.",
)
.or("1");

const ALPHA: Field = Field::new(
    "alpha",
    Takes::Varying(Range::SHARE),
    "The share of light that it stops; the rest passes straight on, as if the surface were not there. For quads, disks and meshes.",
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
    "Whether the colours of a mesh's vertices multiply its colour. Those of glTF files are read (`COLOR_0`).",
)
.or("false");
const VERTEX_ALPHA: Field = Field::new(
    "vertex_alpha",
    Takes::Other("true or false"),
    "Whether the alpha of a mesh's vertices multiplies its alpha. That of glTF files is read (`COLOR_0`) where the file's own material has the \
     alphaMode MASK or BLEND.",
)
.or("false");

const MULTISCATTER: Field = Field::new(
    "multiscatter",
    Takes::Other("true or false"),
    "Whether it makes up for the light that its microfacets would reflect more than once, by Turquin's factor. Otherwise that light is lost.",
)
.or("false");

const SPECULAR: Field =
    Field::new("specular", Takes::Number(Range::SHARE, NO_UNIT), "All that the layer reflects is multiplied by this.")
        .or("1");
const SPECULAR_COLOR: Field = Field::new(
    "specular_color",
    Takes::Texture(Use::Albedo.range()),
    "What the layer reflects of light straight on it is multiplied by this colour; grazing light keeps its own.",
)
.or("Rgb(1, 1, 1)");

impl<'a> Extension<'a> {
    pub fn emission(slot: Slot<'a>, two_sided: bool) -> Extension<'a> {
        Extension { kind: ExtensionKind::Emission, slot, parameter: f32::from(u8::from(two_sided)) }
    }
}

/// A material's number that may vary: the number, or 0 and the extension that stands for it.
fn varying<'a>(
    field: &'static Field,
    kind: ExtensionKind,
    texture: &'a Texture,
) -> (f64, Option<Number>, Option<Extension<'a>>) {
    match texture.plain() {
        Some(grey) => (grey.x, Some(Number { field, value: grey.x, warning: None }), None),
        None => {
            let slot = Slot { field, usage: Use::Share, texture };
            (0.0, None, Some(Extension { kind, slot, parameter: 0.0 }))
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
    /// Adds an emission beside what the material scatters.
    fn glowing(mut self, emission: &'a Option<Texture>) -> Model<'a> {
        let slot = |texture| Slot { field: &EMISSION, usage: Use::Radiance, texture };
        self.extensions.extend(emission.as_ref().map(|texture| Extension::emission(slot(texture), true)));
        self
    }

    /// The model with an alpha: it stops this share of light, which the alpha of a mesh's vertices may multiply. With a cutoff, it stops all
    /// light where its alpha is at least that, and none elsewhere.
    fn cut_out(mut self, alpha: &'a Texture, cutoff: Option<f64>, of_vertices: bool) -> Model<'a> {
        let least = cutoff.unwrap_or(1.0);
        let stops_all = !of_vertices && alpha.plain().is_some_and(|alpha| alpha.x >= least);
        let slot = Slot { field: &ALPHA, usage: Use::Share, texture: alpha };
        let parameter = cutoff.map_or(-1.0, |cutoff| cutoff as f32);
        self.extensions.extend((!stops_all).then_some(Extension { kind: ExtensionKind::Alpha, slot, parameter }));
        let numbers = alpha.plain().map(|alpha| (&ALPHA, alpha.x)).into_iter();
        let numbers = numbers.chain(cutoff.map(|cutoff| (&ALPHA_CUTOFF, cutoff)));
        self.numbers.extend(numbers.map(|(field, value)| Number { field, value, warning: None }));
        self.flagged(&VERTEX_ALPHA, ExtensionKind::VertexAlpha, of_vertices)
    }

    /// Lets each surface of a clear solid pass this share of light.
    fn tinted(mut self, transmittance: &'a Option<Texture>) -> Model<'a> {
        let slot = |texture| Slot { field: &TRANSMITTANCE, usage: Use::Albedo, texture };
        self.slot = transmittance.as_ref().map(slot);
        self.on_device.colour = [1.0; 3];
        self
    }

    /// Makes a clear solid absorb this much per scene unit.
    fn absorbing(mut self, absorption: Option<Colour>) -> Model<'a> {
        self.absorption = absorption;
        self.colours.extend(absorption.map(|colour| (&ABSORPTION, colour)));
        self
    }

    /// Adds an extension if `is_there`. Its data lie elsewhere, so its row is white.
    fn flagged(mut self, field: &'static Field, kind: ExtensionKind, is_there: bool) -> Model<'a> {
        static WHITE: Texture = Texture::Rgb(1.0, 1.0, 1.0);
        let slot = Slot { field, usage: Use::Share, texture: &WHITE };
        self.extensions.extend(is_there.then_some(Extension { kind, slot, parameter: 0.0 }));
        self
    }

    /// Multiplies the colour by those of a mesh's vertices.
    fn coloured_by_vertices(self, has_them: bool) -> Model<'a> {
        self.flagged(&VERTEX_COLORS, ExtensionKind::VertexColours, has_them)
    }

    /// Makes up for light that the microfacets scatter more than once.
    fn scattering_many_times(self, does: bool) -> Model<'a> {
        self.flagged(&MULTISCATTER, ExtensionKind::Multiscatter, does)
    }

    /// Adds a normal map.
    fn bumped(mut self, normal: &'a Option<Texture>, scale: f64) -> Model<'a> {
        let slot = |texture| Slot { field: &NORMAL, usage: Use::Normal, texture };
        let map = |texture| Extension { kind: ExtensionKind::Normal, slot: slot(texture), parameter: scale as f32 };
        self.extensions.extend(normal.as_ref().map(map));
        self.numbers.push(Number { field: &NORMAL_SCALE, value: scale, warning: None });
        self
    }

    /// Adds a layer that reflects this share, and in this colour at normal incidence (KHR_materials_specular).
    fn layered(mut self, share: f64, colour: &'a Texture) -> Model<'a> {
        let slot = Slot { field: &SPECULAR_COLOR, usage: Use::Albedo, texture: colour };
        let extension = Extension { kind: ExtensionKind::Specular, slot, parameter: share as f32 };
        self.extensions.extend((share != 1.0 || !is_white(colour)).then_some(extension));
        self.numbers.push(Number { field: &SPECULAR, value: share, warning: None });
        self
    }

    /// What it emits, if it does not scatter.
    pub fn light(&self) -> Option<Emission<'a>> {
        Some(Emission { slot: self.slot?, two_sided: self.two_sided? })
    }

    /// What it emits, whether it scatters or not.
    pub fn emission(&self) -> Option<Emission<'a>> {
        let glow = || self.extensions.iter().find(|extension| extension.kind == ExtensionKind::Emission);
        self.light().or_else(|| {
            let Extension { slot, parameter, .. } = *glow()?;
            Some(Emission { slot, two_sided: parameter != 0.0 })
        })
    }

    /// Its textures, also plain ones: its own first, then those of its extensions in their order.
    pub fn slots(&self) -> impl Iterator<Item = Slot<'a>> + use<'a, '_> {
        self.slot.into_iter().chain(self.extensions.iter().map(|extension| extension.slot))
    }
}

impl Slot<'_> {
    fn warning(&self, at: &Place, bitmaps: &Bitmaps) -> Option<String> {
        let (is_odd, message) = match self.usage {
            Use::Share | Use::Normal => return None,
            // Light leaves a clear body, so that a transmittance of 1 traps no path.
            Use::Albedo if self.field.name == TRANSMITTANCE.name => return None,
            // What a layer does not reflect reaches the matt body.
            Use::Albedo if self.field.name == SPECULAR_COLOR.name => return None,
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

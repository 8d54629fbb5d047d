//! The properties of materials, as the rest of the host sees them.

use super::declared::{conductor, dielectric, is_white, is_zero, lambertian, pbr};
use crate::bitmap::Bitmaps;
use crate::data;
use crate::source::ValuePath;
use crate::source::form::Field;
use crate::texture::{Colour, Texture, Use};

/// A roughness below this makes a smooth surface, as shaders/lib/microfacet says.
pub const LEAST_ROUGHNESS: f32 = 1.0 / 1024.0;

/// How much larger a kernel may find an interpolated number, relative to it.
const ROUNDING: f32 = 1.0 / (1u32 << 20) as f32;

/// The properties that all materials of a kind share.
#[derive(Debug)]
pub struct MaterialKind {
    /// The name of its file under shaders/material.
    pub shader: &'static str,
    /// The lobes that materials of the kind can have. If one of them is not specular, a second file SHADER_eval evaluates the BSDF for
    /// light sampling.
    pub lobes: &'static [Lobe],
    /// Whether it transmits light.
    pub is_transmissive: bool,
    /// Whether light passes its smooth surfaces straight on, which is no event. Its shader file then has SHADER_reflectance.
    pub is_pane: bool,
    pub emits: bool,
    /// The extensions that materials of the kind may have.
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
pub const ANY_LOBE: &[Lobe] = &[Lobe::Wide, Lobe::Narrow, Lobe::Specular];

/// The properties of a material on the host.
#[derive(Default)]
pub struct Model<'a> {
    /// Its texture, if it has one.
    pub slot: Option<Slot<'a>>,
    /// None if it does not scatter. Those of a roughness of 0 where the roughness is a texture.
    pub lobes: Vec<Lobe>,
    /// Whether it emits to both sides; none if it does not emit. Its texture is the emitted radiance.
    pub two_sided: Option<bool>,
    /// A warning about a number that is allowed but likely to disappoint, with the field that holds it.
    pub warning: Option<(&'static Field, String)>,
    /// What is expected, if fields that exclude or require each other are not given so.
    pub lacks: Option<&'static str>,
    /// Its extensions.
    pub extensions: Vec<Extension<'a>>,
    /// Of a clear solid: what it absorbs per scene unit.
    pub absorption: Option<Colour>,
    /// The struct that kernels read. The texture and the number of the kind are filled in later.
    pub on_device: data::Material,
    /// The second part as kernels read it, if the kind has one.
    pub second_part: Option<data::Material>,
}

/// A texture of a material, with the field that holds it.
#[derive(Clone, Copy, Debug)]
pub struct Slot<'a> {
    pub field: &'static Field,
    pub usage: Use,
    pub texture: &'a Texture,
}

macro_rules! extensions {
    ($($(#[$about:meta])* $kind:ident = $name:literal $(, a lobe: $label:literal)?;)*) => {
        /// The extensions of materials, each with its own row of the table of materials.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum ExtensionKind { $($(#[$about])* $kind,)* }

        impl ExtensionKind {
            /// All, by the names of their members of `Extension` on the device, in the order of these.
            pub const ALL: &'static [(&'static str, ExtensionKind)] = &[$(($name, ExtensionKind::$kind)),*];

            /// The lobes among them, by name: what `plan` calls one, and its module.
            pub const LOBES: &'static [(&'static str, (&'static str, &'static str))] =
                &[$($(($name, ($label, concat!("lobe/", $name))),)?)*];
        }
    };
}

extensions! {
    /// The radiance that it emits in addition to what it scatters. The row's parameter is 0 if it emits from its front alone.
    Emission = "emission";
    /// The share of light that it stops.
    Alpha = "alpha";
    /// Its roughness, where that varies over the surface.
    Roughness = "roughness";
    /// How metallic it is, where that varies.
    Metallic = "metallic";
    /// The normal in the frame of the texture coordinates.
    Normal = "normal";
    /// The colours of a mesh's vertices, which multiply its own. The row is not read.
    VertexColours = "vertex_colours";
    /// It makes up for light that microfacets scatter more than once. The row is not read.
    Multiscatter = "multiscatter";
    /// The colour multiplies what the layer of glTF's material reflects of light straight on it, the parameter what it reflects at all angles.
    Specular = "specular";
    /// The alpha of a mesh's vertices, which multiplies its own. The row is not read.
    VertexAlpha = "vertex_alpha";
    /// The colours of a mesh's vertices, which multiply what it emits. The row is not read.
    VertexEmission = "vertex_emission";
    /// How much the layer of glTF's material reflects, where that varies.
    SpecularShare = "specular_share";
    /// The share of glass in glTF's material. The row has the numbers of a dielectric; its parameter is 0 of a pane.
    Transmission = "transmission", a lobe: "pbr transmission";
    /// The share of a coat around glTF's material, with its roughness as the parameter and its reflectance straight on as `contrast_outside`.
    Coat = "coat", a lobe: "pbr coat";
    /// The roughness of the coat, where that varies.
    CoatRoughness = "coat_roughness";
    /// The normal of the coat.
    CoatNormal = "coat_normal";
    /// The colour of the sheen on glTF's material, with its roughness as the parameter.
    Sheen = "sheen", a lobe: "pbr sheen";
    /// The roughness of the sheen, where that varies.
    SheenRoughness = "sheen_roughness";
    /// The direction along which microfacets are rougher, and by how much: the factor of the strength is the parameter, the cosine and the sine of
    /// the rotation are the contrasts.
    Anisotropy = "anisotropy", a lobe: "anisotropy";
    /// The share of a thin film on glTF's material, with its index of refraction as the parameter and its thickness in nm as `contrast_outside`.
    Iridescence = "iridescence", a lobe: "pbr film";
    /// The thickness of the film where that varies, from `contrast_outside` to `contrast_inside`.
    IridescenceThickness = "iridescence_thickness";
    /// The colour of scattered light that passes glTF's material, with its share as the parameter.
    DiffuseTransmission = "diffuse_transmission", a lobe: "pbr diffuse transmission";
    /// The share of that light, where it varies.
    DiffuseTransmissionShare = "diffuse_transmission_share";
    /// The index of refraction of blue in glass less that of green, as the parameter.
    Dispersion = "dispersion", a lobe: "dispersion";
}

impl ExtensionKind {
    pub fn name(self) -> &'static str {
        ExtensionKind::ALL.get(self as usize).map_or("", |(name, _)| name)
    }

    /// The names of those that kernels evaluate by a module of shaders/extension, in the order of evaluation.
    pub fn evaluated() -> impl Iterator<Item = &'static str> {
        use ExtensionKind::{Alpha, Multiscatter, VertexAlpha, VertexColours, VertexEmission};
        let of_others = [Alpha, Multiscatter, VertexAlpha, VertexColours, VertexEmission];
        ExtensionKind::ALL.iter().filter(move |(_, kind)| !of_others.contains(kind)).map(|(name, _)| *name)
    }
}

/// An extension of a material, with its texture.
#[derive(Clone, Copy, Debug)]
pub struct Extension<'a> {
    pub kind: ExtensionKind,
    pub slot: Slot<'a>,
    /// The parameter of its row. Of an alpha it is the cutoff, or -1.
    pub parameter: f32,
    /// Two more numbers of its row.
    pub contrasts: [f32; 2],
}

impl<'a> Extension<'a> {
    pub fn new(kind: ExtensionKind, slot: Slot<'a>, parameter: f32) -> Extension<'a> {
        Extension { kind, slot, parameter, contrasts: [0.0; 2] }
    }

    /// An extension without a texture.
    fn white(field: &'static Field, kind: ExtensionKind, parameter: f32) -> Extension<'a> {
        static WHITE: Texture = Texture::Rgb(1.0, 1.0, 1.0);
        Extension::new(kind, Slot { field, usage: Use::Share, texture: &WHITE }, parameter)
    }

    pub fn emission(slot: Slot<'a>, two_sided: bool) -> Extension<'a> {
        Extension::new(ExtensionKind::Emission, slot, f32::from(u8::from(two_sided)))
    }
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

/// The lobes of microfacets, by those of a roughness and an anisotropy, for a roughness that may vary: as narrow as its least number makes them,
/// and wider.
pub fn lobes_of_roughness(
    roughness: &Texture,
    along: Along,
    bitmaps: &Bitmaps,
    lobes: impl Fn(f64, f64) -> Vec<Lobe>,
) -> Vec<Lobe> {
    let least = roughness.least(bitmaps);
    let narrowest = lobes(least, if along.varies { 0.0 } else { along.strength });
    let varies = roughness.plain().is_none() || along.varies;
    let may_have = |lobe: &Lobe| narrowest.iter().any(|own| own == lobe || varies && own < lobe);
    [Lobe::Specular, Lobe::Narrow, Lobe::Wide].into_iter().filter(may_have).collect()
}

/// A material's number that may vary: the number, or 0 and the extension that stands for it.
pub fn varying<'a>(field: &'static Field, kind: ExtensionKind, texture: &'a Texture) -> (f64, Option<Extension<'a>>) {
    let slot = Slot { field, usage: Use::Share, texture };
    let number = texture.plain().map(|grey| grey.x);
    (number.unwrap_or(0.0), number.is_none().then_some(Extension::new(kind, slot, 0.0)))
}

/// A coat around glTF's material.
pub struct Coat<'a> {
    pub share: &'a Texture,
    pub roughness: &'a Texture,
    pub ior: f64,
    pub normal: &'a Option<Texture>,
    pub normal_scale: f64,
}

/// A thin film on glTF's material.
pub struct Film<'a> {
    pub share: &'a Texture,
    pub ior: f64,
    /// Where it varies, a share of the way from the least thickness to the largest, both in nm.
    pub thickness: &'a Texture,
    pub least: f64,
    pub most: f64,
}

/// The emission of a material.
#[derive(Clone, Copy, Debug)]
pub struct Emission<'a> {
    pub slot: Slot<'a>,
    pub two_sided: bool,
}

/// The attributes of vertices that the meshes with a material have.
#[derive(Clone, Copy, Debug, Default)]
pub struct Vertices {
    pub colours: bool,
    pub alphas: bool,
}

/// The most that a material emits.
#[derive(Clone, Copy, Debug, Default)]
pub struct Emitted {
    /// The largest component of the radiance.
    pub radiance: f64,
    /// The largest coverage of the surface.
    pub coverage: f64,
}

impl Emitted {
    /// Whether paths can meet it.
    pub fn is_seen(&self) -> bool {
        self.radiance > 0.0 && self.coverage > 0.0
    }
}

impl<'a> Model<'a> {
    /// Adds an emission to a material that scatters.
    pub fn emissive(mut self, emission: &'a Option<Texture>) -> Model<'a> {
        let slot = |texture| Slot { field: &lambertian::FIELDS.emission, usage: Use::Radiance, texture };
        self.extensions.extend(emission.as_ref().map(|texture| Extension::emission(slot(texture), true)));
        self
    }

    /// The model with an alpha: it stops this share of light, which the alpha of a mesh's vertices may multiply. With a cutoff, it stops all
    /// light where its alpha is at least that, and none elsewhere.
    pub fn cut_out(mut self, alpha: &'a Texture, cutoff: Option<f64>, of_vertices: bool) -> Model<'a> {
        let least = cutoff.unwrap_or(1.0);
        let stops_all = !of_vertices && alpha.plain().is_some_and(|alpha| alpha.x >= least);
        let slot = Slot { field: &lambertian::FIELDS.alpha, usage: Use::Share, texture: alpha };
        let parameter = cutoff.map_or(-1.0, |cutoff| cutoff as f32);
        self.extensions.extend((!stops_all).then_some(Extension::new(ExtensionKind::Alpha, slot, parameter)));
        self.flagged(&lambertian::FIELDS.vertex_alpha, ExtensionKind::VertexAlpha, of_vertices)
    }

    /// Lets each surface of a clear solid pass this share of light.
    pub fn tinted(mut self, transmittance: &'a Option<Texture>) -> Model<'a> {
        let slot = |texture| Slot { field: &dielectric::FIELDS.transmittance, usage: Use::Albedo, texture };
        self.slot = transmittance.as_ref().map(slot);
        self.on_device.colour = [1.0; 3];
        self
    }

    /// Makes a clear solid absorb this much per scene unit.
    pub fn absorbing(mut self, absorption: Option<Colour>) -> Model<'a> {
        self.absorption = absorption;
        self
    }

    /// Adds an extension if `is_there`. Its data lie elsewhere, so its row is white.
    fn flagged(mut self, field: &'static Field, kind: ExtensionKind, is_there: bool) -> Model<'a> {
        self.extensions.extend(is_there.then(|| Extension::white(field, kind, 0.0)));
        self
    }

    /// Multiplies the colour by those of a mesh's vertices.
    pub fn coloured_by_vertices(self, has_them: bool) -> Model<'a> {
        self.flagged(&lambertian::FIELDS.vertex_colors, ExtensionKind::VertexColours, has_them)
    }

    /// Multiplies the emitted radiance by the colours of a mesh's vertices.
    pub fn emissive_by_vertices(self, does: bool) -> Model<'a> {
        self.flagged(&lambertian::FIELDS.vertex_emission, ExtensionKind::VertexEmission, does)
    }

    /// Makes up for light that the microfacets scatter more than once.
    pub fn scattering_many_times(self, does: bool) -> Model<'a> {
        self.flagged(&conductor::FIELDS.multiscatter, ExtensionKind::Multiscatter, does)
    }

    /// Adds a normal map.
    pub fn bumped(mut self, normal: &'a Option<Texture>, scale: f64) -> Model<'a> {
        let slot = |texture| Slot { field: &lambertian::FIELDS.normal, usage: Use::Normal, texture };
        let map = |texture| Extension::new(ExtensionKind::Normal, slot(texture), scale as f32);
        self.extensions.extend(normal.as_ref().map(map));
        self
    }

    /// Adds a layer that reflects this share, and in this colour at normal incidence (KHR_materials_specular). Kernels read it as such if it is
    /// not plain, and below a film.
    pub fn layered(mut self, share: &'a Texture, colour: &'a Texture, has_film: bool) -> Model<'a> {
        let slot = Slot { field: &pbr::FIELDS.specular_color, usage: Use::Albedo, texture: colour };
        let of_share = Slot { field: &pbr::FIELDS.specular, usage: Use::Share, texture: share };
        let number = share.plain().map_or(1.0, |share| share.x);
        let varying = Extension::new(ExtensionKind::SpecularShare, of_share, 0.0);
        let is_own = has_film || !is_white(share) || !is_white(colour);
        self.extensions.extend(is_own.then_some(Extension::new(ExtensionKind::Specular, slot, number as f32)));
        self.extensions.extend(of_share.is_textured().then_some(varying));
        self
    }

    /// Adds a share of glass: a solid, or a pane. `glass` is a dielectric as kernels read it.
    pub fn transmitting(mut self, share: &'a Texture, glass: &data::Material, is_solid: bool) -> Model<'a> {
        let slot = Slot { field: &pbr::FIELDS.transmission, usage: Use::Share, texture: share };
        let extension = Extension {
            contrasts: [glass.contrast_outside, glass.contrast_inside],
            ..Extension::new(ExtensionKind::Transmission, slot, if is_solid { glass.parameter } else { 0.0 })
        };
        self.extensions.extend((!is_zero(share)).then_some(extension));
        self
    }

    /// Adds a coat of this index of refraction, with a normal map of its own.
    pub fn coated(mut self, coat: Coat<'a>) -> Model<'a> {
        if is_zero(coat.share) {
            return self;
        }
        let slot = Slot { field: &pbr::FIELDS.coat, usage: Use::Share, texture: coat.share };
        let (roughness, varying) = varying(&pbr::FIELDS.coat_roughness, ExtensionKind::CoatRoughness, coat.roughness);
        let reflectance = ((coat.ior - 1.0) / (coat.ior + 1.0)).powi(2);
        self.extensions.push(Extension {
            contrasts: [reflectance as f32, 0.0],
            ..Extension::new(ExtensionKind::Coat, slot, roughness as f32)
        });
        self.extensions.extend(varying);
        let slot = |texture| Slot { field: &pbr::FIELDS.coat_normal, usage: Use::Normal, texture };
        let map = |texture| Extension::new(ExtensionKind::CoatNormal, slot(texture), coat.normal_scale as f32);
        self.extensions.extend(coat.normal.as_ref().map(map));
        self
    }

    /// Adds a sheen.
    pub fn sheened(mut self, colour: &'a Texture, roughness: &'a Texture) -> Model<'a> {
        if is_zero(colour) {
            return self;
        }
        let slot = Slot { field: &pbr::FIELDS.sheen, usage: Use::Albedo, texture: colour };
        let (number, varying) = varying(&pbr::FIELDS.sheen_roughness, ExtensionKind::SheenRoughness, roughness);
        self.extensions.push(Extension::new(ExtensionKind::Sheen, slot, number as f32));
        self.extensions.extend(varying);
        self
    }

    /// Makes microfacets rougher along a direction: by a strength from 0 to 1, and turned by degrees from u towards v.
    pub fn anisotropic(mut self, strength: f64, rotation: f64, texture: &'a Option<Texture>) -> Model<'a> {
        // The direction of u, and all of the strength.
        static ALONG_U: Texture = Texture::Rgb(1.0, 0.5, 1.0);
        if strength == 0.0 {
            return self;
        }
        let texture = texture.as_ref().unwrap_or(&ALONG_U);
        let slot = Slot { field: &conductor::FIELDS.anisotropy_texture, usage: Use::Direction, texture };
        let (sine, cosine) = rotation.to_radians().sin_cos();
        self.extensions.push(Extension {
            contrasts: [cosine as f32, sine as f32],
            ..Extension::new(ExtensionKind::Anisotropy, slot, strength as f32)
        });
        self
    }

    /// Adds a thin film.
    pub fn filmed(mut self, film: Film<'a>) -> Model<'a> {
        if is_zero(film.share) {
            return self;
        }
        let slot = Slot { field: &pbr::FIELDS.iridescence, usage: Use::Share, texture: film.share };
        let of_thickness =
            Slot { field: &pbr::FIELDS.iridescence_thickness_texture, usage: Use::Share, texture: film.thickness };
        let share = film.thickness.plain().map_or(1.0, |share| share.x);
        let thickness = film.least + share * (film.most - film.least);
        self.extensions.push(Extension {
            contrasts: [thickness as f32, 0.0],
            ..Extension::new(ExtensionKind::Iridescence, slot, film.ior as f32)
        });
        let varying = Extension {
            contrasts: [film.least as f32, film.most as f32],
            ..Extension::new(ExtensionKind::IridescenceThickness, of_thickness, 0.0)
        };
        self.extensions.extend(of_thickness.is_textured().then_some(varying));
        self
    }

    /// Lets this share of the light that the matt body scatters pass to the far side.
    pub fn translucent(mut self, share: &'a Texture, colour: &'a Texture) -> Model<'a> {
        if is_zero(share) {
            return self;
        }
        let slot = Slot { field: &pbr::FIELDS.diffuse_transmission_color, usage: Use::Albedo, texture: colour };
        let (number, varying) =
            varying(&pbr::FIELDS.diffuse_transmission, ExtensionKind::DiffuseTransmissionShare, share);
        self.extensions.push(Extension::new(ExtensionKind::DiffuseTransmission, slot, number as f32));
        self.extensions.extend(varying);
        self
    }

    /// Gives glass of this index one for each channel. A `dispersion` is 20 over the Abbe number, and the indices of blue and red differ
    /// from that of green by (ior - 1) / 40 of it (KHR_materials_dispersion).
    pub fn dispersing(mut self, ior: f64, dispersion: f64) -> Model<'a> {
        if dispersion == 0.0 {
            return self;
        }
        if ior < 1.0 {
            self.lacks = Some("no dispersion with an ior below 1");
        }
        let spread = (ior - 1.0) / 40.0 * dispersion;
        self.extensions.push(Extension::white(
            &dielectric::FIELDS.dispersion,
            ExtensionKind::Dispersion,
            spread as f32,
        ));
        self
    }

    /// What it emits, if it does not scatter.
    pub fn light(&self) -> Option<Emission<'a>> {
        Some(Emission { slot: self.slot?, two_sided: self.two_sided? })
    }

    /// What it emits, whether it scatters or not.
    pub fn emission(&self) -> Option<Emission<'a>> {
        let emission_extension = || self.extensions.iter().find(|extension| extension.kind == ExtensionKind::Emission);
        self.light().or_else(|| {
            let Extension { slot, parameter, .. } = *emission_extension()?;
            Some(Emission { slot, two_sided: parameter != 0.0 })
        })
    }

    pub fn has(&self, kind: ExtensionKind) -> bool {
        self.find(kind).is_some()
    }

    fn find(&self, kind: ExtensionKind) -> Option<&Extension<'a>> {
        self.extensions.iter().find(|extension| extension.kind == kind)
    }

    /// The model without what changes nothing on objects whose vertices have this. `metallic` is the share of metal, if it is one number.
    pub fn without_neutral(mut self, vertices: Vertices, metallic: Option<f64>) -> Model<'a> {
        self.absorption = self.absorption.filter(|absorption| *absorption != Colour::ZERO);
        self.slot = self
            .slot
            .filter(|slot| slot.field.name != dielectric::FIELDS.transmittance.name || !is_white(slot.texture));
        self.extensions.retain(|extension| match extension.kind {
            ExtensionKind::Emission => !is_zero(extension.slot.texture),
            ExtensionKind::VertexColours | ExtensionKind::VertexEmission => vertices.colours,
            ExtensionKind::VertexAlpha => vertices.alphas,
            ExtensionKind::Normal | ExtensionKind::CoatNormal => extension.parameter != 0.0,
            ExtensionKind::Transmission
            | ExtensionKind::DiffuseTransmission
            | ExtensionKind::DiffuseTransmissionShare => metallic != Some(1.0),
            ExtensionKind::Dispersion => extension.parameter != 0.0 && metallic != Some(1.0),
            _ => true,
        });
        let alpha_of_vertices = self.has(ExtensionKind::VertexAlpha);
        let lets_pass = self.find(ExtensionKind::Alpha).is_some_and(|alpha| {
            let least = if alpha.parameter >= 0.0 { alpha.parameter } else { 1.0 };
            match alpha.slot.texture.plain() {
                Some(plain) if !alpha_of_vertices => (plain.x as f32) < least,
                _ => least > 0.0,
            }
        });
        let emits = self.emission().is_some();
        let [is_rough, is_brushed] = [ExtensionKind::Roughness, ExtensionKind::Anisotropy].map(|kind| self.has(kind));
        let is_mirror = self.on_device.parameter < LEAST_ROUGHNESS && !is_rough && !is_brushed;
        // A film without a thickness is none (shaders/lobe/iridescence), and one of the index of air has no boundary.
        let has_film = self.find(ExtensionKind::Iridescence).is_some_and(|film| {
            let thickness =
                self.find(ExtensionKind::IridescenceThickness).map_or(film.contrasts, |film| film.contrasts);
            film.parameter != 1.0 && thickness != [0.0; 2]
        });
        let share = self.has(ExtensionKind::SpecularShare);
        let has_layer = self
            .find(ExtensionKind::Specular)
            .is_some_and(|layer| has_film || share || layer.parameter != 1.0 || !is_white(layer.slot.texture));
        self.extensions.retain(|extension| match extension.kind {
            ExtensionKind::Alpha | ExtensionKind::VertexAlpha => lets_pass,
            ExtensionKind::VertexEmission => emits,
            ExtensionKind::Multiscatter => !is_mirror,
            ExtensionKind::Iridescence | ExtensionKind::IridescenceThickness => has_film,
            ExtensionKind::Specular => has_layer,
            _ => true,
        });
        self
    }

    /// Whether it lets light pass straight on somewhere.
    pub fn has_alpha(&self) -> bool {
        self.has(ExtensionKind::Alpha)
    }

    /// The most that it emits. `of_vertices` gives the largest alpha and colour of the vertices of its objects.
    pub fn most_emitted(&self, bitmaps: &Bitmaps, of_vertices: impl Fn() -> [f64; 2]) -> Emitted {
        let Some(emission) = self.emission() else { return Emitted::default() };
        let reads = [ExtensionKind::VertexAlpha, ExtensionKind::VertexEmission].map(|kind| self.has(kind));
        let largest = if reads.contains(&true) { of_vertices() } else { [1.0; 2] };
        let [alpha, colour] = [0, 1].map(|i| if reads[i] { largest[i] } else { 1.0 });
        let coverage = self.find(ExtensionKind::Alpha).map_or(1.0, |extension| {
            let alpha = (alpha * extension.slot.texture.brightest(bitmaps)) as f32;
            match extension.parameter {
                // Kernels round an alpha between texels.
                cutoff if cutoff >= 0.0 => f64::from(u8::from(alpha * (1.0 + ROUNDING) >= cutoff)),
                _ => f64::from(alpha),
            }
        });
        Emitted { radiance: colour * emission.slot.texture.brightest(bitmaps), coverage }
    }

    /// Its textures, also plain ones: its own first, then those of its extensions in their order.
    pub fn slots(&self) -> impl Iterator<Item = Slot<'a>> + use<'a, '_> {
        self.slot.into_iter().chain(self.extensions.iter().map(|extension| extension.slot))
    }

    /// The slots that have a frame on objects, in the order of the frames.
    pub fn framed(&self) -> Vec<Slot<'a>> {
        self.slots().filter(Slot::has_frame).collect()
    }
}

impl Slot<'_> {
    /// Whether the texture is no plain colour.
    pub fn is_textured(&self) -> bool {
        self.texture.plain().is_none()
    }

    /// Whether objects have a frame for it: for a texture, or for the direction of its coordinates.
    pub fn has_frame(&self) -> bool {
        self.is_textured() || self.usage == Use::Direction
    }

    pub fn warning(&self, at: &ValuePath, bitmaps: &Bitmaps) -> Option<String> {
        let (is_odd, message) = match self.usage {
            Use::Share | Use::Normal | Use::Direction => return None,
            // Light leaves a clear body, so that a transmittance of 1 traps no path.
            Use::Albedo if self.field.name == dielectric::FIELDS.transmittance.name => return None,
            // What a layer does not reflect reaches the matt body.
            Use::Albedo if self.field.name == pbr::FIELDS.specular_color.name => return None,
            Use::Albedo if self.field.name == pbr::FIELDS.sheen.name => return None,
            Use::Albedo if self.field.name == pbr::FIELDS.diffuse_transmission_color.name => return None,
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

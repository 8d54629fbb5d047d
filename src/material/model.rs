//! The properties of materials, as the rest of the host sees them.

use super::declared::{Distribution, conductor, dielectric, is_white, is_zero, lambertian};
use super::row::{
    ALPHA, BECKMANN, EMISSION, MULTISCATTER, NORMAL, ONE_SIDED, ROUGHNESS, Row, RowKind, Slot, VERTEX_ALPHA,
    VERTEX_COLOURS, VERTEX_EMISSION,
};
use super::width::{LEAST_ROUGHNESS, LobeWidth};
use crate::bitmap::Bitmaps;
use crate::data;
use crate::lobe::anisotropy::ANISOTROPY;
use crate::lobe::{LOBES, dispersion};
use crate::source::ValuePath;
use crate::source::form::Field;
use crate::texture::{Colour, Texture, Use};

/// How much larger a kernel may find an interpolated number, relative to it.
const ROUNDING: f32 = 1.0 / (1u32 << 20) as f32;

/// The properties that all materials of a kind share.
#[derive(Debug)]
pub struct MaterialKind {
    /// The name of its file under shaders/material.
    pub shader: &'static str,
    /// The names of its numbers: `material.${metal.fuzz}` in shaders.
    pub numbers: &'static [&'static str],
    /// The names of the numbers of its second part, `hit.second.${rough_dielectric.ior}`, if kernels read more of it than one element of their
    /// table holds. Then it has two of them.
    pub second_part: &'static [&'static str],
    /// The widths of the lobes that materials of the kind can have. If one of them is not specular, a second file SHADER_eval evaluates the
    /// BSDF for light sampling.
    pub widths: &'static [LobeWidth],
    /// Whether it transmits light.
    pub is_transmissive: bool,
    /// Whether light passes its smooth surfaces straight on, which is no event. Its shader file then has SHADER_reflectance.
    pub is_pane: bool,
    pub emits: bool,
    /// The rows that materials of the kind may have.
    pub rows: &'static [&'static RowKind],
    /// Whether they may have all lobes.
    pub has_lobes: bool,
}

impl MaterialKind {
    /// A kind with lobes of these widths that has nothing else.
    pub const fn new(shader: &'static str, widths: &'static [LobeWidth]) -> MaterialKind {
        MaterialKind {
            shader,
            numbers: &[],
            second_part: &[],
            widths,
            is_transmissive: false,
            is_pane: false,
            emits: false,
            rows: &[],
            has_lobes: false,
        }
    }

    /// Whether kernels have functions of the kind: it scatters or emits.
    pub const fn has_functions(&self) -> bool {
        self.emits || !self.widths.is_empty()
    }

    /// Whether materials of the kind may have such a row.
    pub fn can_have(&self, row: &RowKind) -> bool {
        self.rows.contains(&row) || self.has_lobes && LOBES.iter().any(|lobe| lobe.rows.contains(&row))
    }
}

/// The properties of a material on the host.
#[derive(Default)]
pub struct Model<'a> {
    /// Its texture, if it has one.
    pub slot: Option<Slot<'a>>,
    /// The widths of its lobes; none if it does not scatter. Those of a roughness of 0 where the roughness is a texture.
    pub widths: Vec<LobeWidth>,
    /// Whether it emits to both sides; none if it does not emit. Its texture is the emitted radiance.
    pub two_sided: Option<bool>,
    /// A warning about a number that is allowed but likely to disappoint, with the field that holds it.
    pub warning: Option<(&'static Field, String)>,
    /// What is expected, if fields that exclude or require each other are not given so.
    pub lacks: Option<&'static str>,
    /// Its further rows.
    pub rows: Vec<Row<'a>>,
    /// Of a clear solid: what it absorbs per scene unit.
    pub absorption: Option<Colour>,
    /// The struct that kernels read. The texture and the number of the kind are filled in later.
    pub on_device: data::Material,
    /// The second part as kernels read it, if the kind has one.
    pub second_part: Option<data::Material>,
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
    /// Makes its back black, if `is_so`. An emission that it has is that of its front alone.
    pub fn one_sided(mut self, is_so: bool) -> Model<'a> {
        if let Some(emission) = self.rows.iter_mut().find(|row| row.kind == EMISSION && is_so) {
            emission.numbers[0] = 0.0;
        }
        self.flagged(&lambertian::FIELDS.one_sided, ONE_SIDED, is_so)
    }

    /// Adds an emission to a material that scatters.
    pub fn emissive(mut self, emission: &'a Option<Texture>, one_sided: bool) -> Model<'a> {
        let slot = |texture| Slot { field: &lambertian::FIELDS.emission, usage: Use::Radiance, texture };
        self.rows.extend(emission.as_ref().map(|texture| emission_row(slot(texture), !one_sided)));
        self
    }

    /// The model with an alpha: it stops this share of light, which the alpha of a mesh's vertices may multiply. With a cutoff, it stops all
    /// light where its alpha is at least that, and none elsewhere.
    pub fn cut_out(mut self, alpha: &'a Texture, cutoff: Option<f64>, of_vertices: bool) -> Model<'a> {
        let least = cutoff.unwrap_or(1.0);
        let stops_all = !of_vertices && alpha.plain().is_some_and(|alpha| alpha.x >= least);
        let slot = Slot { field: &lambertian::FIELDS.alpha, usage: Use::Share, texture: alpha };
        self.rows.extend((!stops_all).then(|| Row::new(ALPHA, slot, &[cutoff.unwrap_or(-1.0)])));
        self.flagged(&lambertian::FIELDS.vertex_alpha, VERTEX_ALPHA, of_vertices)
    }

    /// Lets each surface of a clear solid pass this share of light.
    pub fn tinted(mut self, transmittance: &'a Option<Texture>) -> Model<'a> {
        let slot = |texture| Slot { field: &dielectric::FIELDS.transmittance, usage: Use::Tint, texture };
        self.slot = transmittance.as_ref().map(slot);
        self.on_device.colour = [1.0; 3];
        self
    }

    /// Adds a row if `is_there`. Its data lie elsewhere, so it is white.
    pub fn flagged(mut self, field: &'static Field, kind: &'static RowKind, is_there: bool) -> Model<'a> {
        self.rows.extend(is_there.then(|| Row::white(kind, field, &[])));
        self
    }

    /// Gives its microfacets this distribution.
    pub fn distributed(self, distribution: Distribution) -> Model<'a> {
        self.flagged(&conductor::FIELDS.distribution, BECKMANN, distribution == Distribution::Beckmann)
    }

    /// Adds a normal map.
    pub fn bumped(mut self, normal: &'a Option<Texture>, scale: f64) -> Model<'a> {
        let slot = |texture| Slot { field: &lambertian::FIELDS.normal, usage: Use::Normal, texture };
        self.rows.extend(normal.as_ref().map(|texture| Row::new(NORMAL, slot(texture), &[scale])));
        self
    }

    /// Adds the rows of a lobe.
    pub fn with_rows(mut self, rows: Vec<Row<'a>>) -> Model<'a> {
        self.rows.extend(rows);
        self
    }

    /// Gives glass of this index one for each channel.
    pub fn dispersing(mut self, ior: f64, dispersion: f64) -> Model<'a> {
        if dispersion != 0.0 && ior < 1.0 {
            self.lacks = Some("no dispersion with an ior below 1");
        }
        self.with_rows(dispersion::rows(ior, dispersion))
    }

    /// What it emits, if it does not scatter.
    pub fn light(&self) -> Option<Emission<'a>> {
        Some(Emission { slot: self.slot?, two_sided: self.two_sided? })
    }

    /// What it emits, whether it scatters or not.
    pub fn emission(&self) -> Option<Emission<'a>> {
        self.light().or_else(|| {
            let Row { slot, numbers: [two_sided, ..], .. } = *self.find(EMISSION)?;
            Some(Emission { slot, two_sided: two_sided != 0.0 })
        })
    }

    pub fn has(&self, kind: &RowKind) -> bool {
        self.find(kind).is_some()
    }

    fn find(&self, kind: &RowKind) -> Option<&Row<'a>> {
        self.rows.iter().find(|row| row.kind == kind)
    }

    /// The model without what changes nothing on objects whose vertices have this.
    pub fn without_neutral(mut self, vertices: Vertices) -> Model<'a> {
        self.absorption = self.absorption.filter(|absorption| *absorption != Colour::ZERO);
        self.slot = self
            .slot
            .filter(|slot| slot.field.name != dielectric::FIELDS.transmittance.name || !is_white(slot.texture));
        let counts = |row: &Row<'_>| match row.kind {
            kind if kind == EMISSION => !is_zero(row.slot.texture),
            kind if kind == VERTEX_COLOURS || kind == VERTEX_EMISSION => vertices.colours,
            kind if kind == VERTEX_ALPHA => vertices.alphas,
            // The scale of a normal map.
            _ => row.slot.usage != Use::Normal || row.numbers[0] != 0.0,
        };
        self.rows.retain(counts);
        let alpha_of_vertices = self.has(VERTEX_ALPHA);
        let lets_pass = self.find(ALPHA).is_some_and(|Row { slot, numbers: [cutoff, ..], .. }| {
            let least = if *cutoff >= 0.0 { *cutoff } else { 1.0 };
            match slot.texture.plain() {
                Some(plain) if !alpha_of_vertices => (plain.x as f32) < least,
                _ => least > 0.0,
            }
        });
        let emits = self.emission().is_some();
        let [roughness, ..] = self.on_device.numbers;
        let is_mirror = roughness < LEAST_ROUGHNESS && !self.has(ROUGHNESS) && !self.has(ANISOTROPY);
        self.rows.retain(|row| match row.kind {
            kind if kind == ALPHA || kind == VERTEX_ALPHA => lets_pass,
            kind if kind == VERTEX_EMISSION => emits,
            kind if kind == MULTISCATTER || kind == BECKMANN => !is_mirror,
            _ => true,
        });
        self
    }

    /// Whether it lets light pass straight on somewhere.
    pub fn has_alpha(&self) -> bool {
        self.has(ALPHA)
    }

    /// The most that it emits. `of_vertices` gives the largest alpha and colour of the vertices of its objects.
    pub fn most_emitted(&self, bitmaps: &Bitmaps, of_vertices: impl Fn() -> [f64; 2]) -> Emitted {
        let Some(emission) = self.emission() else { return Emitted::default() };
        let reads = [VERTEX_ALPHA, VERTEX_EMISSION].map(|kind| self.has(kind));
        let largest = if reads.contains(&true) { of_vertices() } else { [1.0; 2] };
        let [alpha, colour] = [0, 1].map(|i| if reads[i] { largest[i] } else { 1.0 });
        let coverage = self.find(ALPHA).map_or(1.0, |row| {
            let alpha = (alpha * row.slot.texture.brightest(bitmaps)) as f32;
            match row.numbers[0] {
                // Kernels round an alpha between texels.
                cutoff if cutoff >= 0.0 => f64::from(u8::from(alpha * (1.0 + ROUNDING) >= cutoff)),
                _ => f64::from(alpha),
            }
        });
        Emitted { radiance: colour * emission.slot.texture.brightest(bitmaps), coverage }
    }

    /// Its textures, also plain ones: its own first, then those of its rows in their order.
    pub fn slots(&self) -> impl Iterator<Item = Slot<'a>> + use<'a, '_> {
        self.slot.into_iter().chain(self.rows.iter().map(|row| row.slot))
    }

    /// The slots that have a frame on objects, in the order of the frames.
    pub fn framed(&self) -> Vec<Slot<'a>> {
        self.slots().filter(Slot::has_frame).collect()
    }
}

/// A material as kernels read it, with these numbers.
pub fn with_numbers(numbers: [f64; 3]) -> data::Material {
    data::Material { numbers: numbers.map(|number| number as f32), ..data::Material::default() }
}

/// The row of an emission.
pub fn emission_row(slot: Slot<'_>, two_sided: bool) -> Row<'_> {
    Row::new(EMISSION, slot, &[f64::from(u8::from(two_sided))])
}

impl Slot<'_> {
    pub fn warning(&self, at: &ValuePath, bitmaps: &Bitmaps) -> Option<String> {
        let (is_odd, message) = match self.usage {
            Use::Share | Use::Tint | Use::Normal | Use::Direction => return None,
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

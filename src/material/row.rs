//! The rows of a material behind its own in the table of materials: textures and numbers that its kind can have and need not.

use crate::source::form::Field;
use crate::texture::{Texture, Use};

/// A kind of row.
#[derive(Debug, PartialEq, Eq)]
pub struct RowKind {
    /// The fact that says that a material has one, and its member of `Rows` on the device.
    pub name: &'static str,
    /// The names of its numbers. In shaders, `row.${coat.f0}` is the number f0 of a row of the kind coat.
    pub numbers: &'static [&'static str],
    pub sets: Sets,
}

/// The members of `EvaluatedMaterial` that a kernel sets by a row.
#[derive(Debug, PartialEq, Eq)]
pub enum Sets {
    /// Nothing: other modules read the row.
    Nothing,
    /// Those that shaders/extension/NAME sets.
    Own,
    /// The members of its lobe: the first by its colour or its share, the others by its numbers.
    Lobe,
    /// This member, by the share from 0 to 1 that the row's texture gives.
    Share(&'static str),
    /// This member, by the texel of the row's texture.
    Texel(&'static str),
}

impl RowKind {
    pub const fn new(name: &'static str, numbers: &'static [&'static str], sets: Sets) -> RowKind {
        RowKind { name, numbers, sets }
    }
}

/// The radiance that it emits in addition to what it scatters: to both sides, or from its front alone.
pub const EMISSION: &RowKind = &RowKind::new("emission", &["two_sided"], Sets::Own);
/// The share of light that it stops. With a cutoff, which is not negative, it stops all light or none.
pub const ALPHA: &RowKind = &RowKind::new("alpha", &["cutoff"], Sets::Nothing);
/// The roughness of microfacets, where it varies.
pub const ROUGHNESS: &RowKind = &RowKind::new("roughness", &[], Sets::Share("material.${pbr.roughness}"));
/// The metallic share, where it varies.
pub const METALLIC: &RowKind = &RowKind::new("metallic", &[], Sets::Share("material.${pbr.metallic}"));
/// The normal in the frame of the texture coordinates, whose x and y have the scale as a factor.
pub const NORMAL: &RowKind = &RowKind::new("normal", &["scale"], Sets::Texel("normal"));
/// The colours of a mesh's vertices multiply its own. The row is not read.
pub const VERTEX_COLOURS: &RowKind = &RowKind::new("vertex_colours", &[], Sets::Nothing);
/// It makes up for light that microfacets scatter more than once. The row is not read.
pub const MULTISCATTER: &RowKind = &RowKind::new("multiscatter", &[], Sets::Nothing);
/// The alpha of a mesh's vertices multiplies its own. The row is not read.
pub const VERTEX_ALPHA: &RowKind = &RowKind::new("vertex_alpha", &[], Sets::Nothing);
/// The colours of a mesh's vertices multiply its emission. The row is not read.
pub const VERTEX_EMISSION: &RowKind = &RowKind::new("vertex_emission", &[], Sets::Nothing);
/// Its back is black: it scatters and emits nothing there. The row is not read.
pub const ONE_SIDED: &RowKind = &RowKind::new("one_sided", &[], Sets::Nothing);
/// A pane reflects as both sides of a slab do. The row is not read.
pub const INNER_REFLECTIONS: &RowKind = &RowKind::new("inner_reflections", &[], Sets::Nothing);

/// The distribution of Beckmann for its microfacets.
pub const BECKMANN: &RowKind = &RowKind::new("beckmann", &[], Sets::Share("beckmann"));

/// The layer on its body is rough. The row is not read.
pub const ROUGH_LAYER: &RowKind = &RowKind::new("rough_layer", &[], Sets::Nothing);

/// Each event has one of two materials, the second with the probability that the texture gives: their indices, and how many frames the first has.
pub const MIX: &RowKind = &RowKind::new("mix", &["first", "second", "frames"], Sets::Nothing);

/// The kinds of row that are of no lobe.
pub const ROWS: &[&RowKind] = &[
    EMISSION,
    ALPHA,
    ROUGHNESS,
    METALLIC,
    NORMAL,
    VERTEX_COLOURS,
    MULTISCATTER,
    VERTEX_ALPHA,
    VERTEX_EMISSION,
    ONE_SIDED,
    INNER_REFLECTIONS,
    BECKMANN,
    ROUGH_LAYER,
    MIX,
];

/// A texture of a material, with the field that holds it.
#[derive(Clone, Copy, Debug)]
pub struct Slot<'a> {
    pub field: &'static Field,
    pub usage: Use,
    pub texture: &'a Texture,
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
}

/// A row of a material.
#[derive(Clone, Copy, Debug)]
pub struct Row<'a> {
    pub kind: &'static RowKind,
    pub slot: Slot<'a>,
    /// The numbers that its kind names, and 0.
    pub numbers: [f32; 3],
}

impl<'a> Row<'a> {
    pub fn new(kind: &'static RowKind, slot: Slot<'a>, numbers: &[f64]) -> Row<'a> {
        let number = |i: usize| numbers.get(i).map_or(0.0, |number| *number as f32);
        Row { kind, slot, numbers: [0, 1, 2].map(number) }
    }

    /// A row without a texture.
    pub fn white(kind: &'static RowKind, field: &'static Field, numbers: &[f64]) -> Row<'a> {
        static WHITE: Texture = Texture::Rgb(1.0, 1.0, 1.0);
        Row::new(kind, Slot { field, usage: Use::Share, texture: &WHITE }, numbers)
    }
}

/// A material's number that may vary: the number, or 0 and the row that stands for it.
pub fn varying<'a>(kind: &'static RowKind, field: &'static Field, texture: &'a Texture) -> (f64, Option<Row<'a>>) {
    let number = texture.plain().map(|grey| grey.x);
    let row = || Row::new(kind, Slot { field, usage: Use::Share, texture }, &[]);
    (number.unwrap_or(0.0), number.is_none().then(row))
}

//! A lobe of a material on the host, and the extension of glTF that it is read from.

use crate::bitmap::{Bitmaps, Channel};
use crate::material::{LobeWidth, Pbr, Row, RowKind};
use crate::texture::Texture;

/// A lobe of `Pbr`, or another part of it that few materials have.
pub struct Lobe {
    /// The name that `plan` gives it, if shaders/lobe/NAME is a module that a scene may need.
    pub label: Option<&'static str>,
    /// The kinds of row that it has. The first is there with the lobe and has its name.
    pub rows: &'static [&'static RowKind],
    /// The members of `Lobes` on the device that it sets, with their types in WGSL.
    pub members: &'static [(&'static str, &'static str)],
    /// Whether it is a layer around the base: a path draws from it, or from what lies below it (shaders/material/pbr).
    pub is_layer: bool,
    /// The rows of a material; none if the material does not have the lobe.
    pub rows_of: for<'a> fn(&'a Pbr) -> Vec<Row<'a>>,
    /// Whether it changes anything of a material that has it.
    pub counts: fn(&Pbr) -> bool,
    /// The widths that it has where it is there.
    pub widths: fn(&Pbr, &Bitmaps) -> Vec<LobeWidth>,
    /// A table of its directional albedo, four elements each. At most one lobe has one.
    pub table: Option<fn() -> &'static [[f32; 4]]>,
    /// The extension of glTF that it is, unless the crate reads that one.
    pub gltf: Option<Gltf>,
}

impl Lobe {
    /// A lobe of these rows that has nothing else.
    pub const fn new(rows: &'static [&'static RowKind], rows_of: for<'a> fn(&'a Pbr) -> Vec<Row<'a>>) -> Lobe {
        Lobe {
            label: None,
            rows,
            members: &[],
            is_layer: false,
            rows_of,
            counts: |_| true,
            widths: |_, _| Vec::new(),
            table: None,
            gltf: None,
        }
    }

    pub fn name(&self) -> &'static str {
        self.rows.first().map_or("", |row| row.name)
    }
}

/// An extension of glTF's materials. It is there where its first factor is not 0.
pub struct Gltf {
    pub extension: &'static str,
    pub fields: &'static [GltfField],
    /// Whether it needs the directions of the texture coordinates without a texture too.
    pub has_direction: bool,
}

/// A factor of a glTF material, with its texture.
pub struct GltfField {
    /// Empty if it has none.
    pub factor: &'static str,
    /// Empty if it has none.
    pub texture: &'static str,
    pub to: To,
}

/// A factor with its texture, by their names in glTF.
pub const fn field(factor: &'static str, texture: &'static str, to: To) -> GltfField {
    GltfField { factor, texture, to }
}

/// Where a field of glTF's goes.
pub enum To {
    /// A factor from 0 to 1, and a channel of the texture. Without a name it is 1, else its default is 0.
    Share(Channel, fn(&mut Pbr) -> &mut Texture),
    /// A colour, with the default of its channels.
    Colour(f64, fn(&mut Pbr) -> &mut Texture),
    Number(fn(&mut Pbr, f64)),
    /// A map, and its scale.
    Map(fn(&mut Pbr) -> &mut Option<Texture>, Option<fn(&mut Pbr) -> &mut f64>),
}

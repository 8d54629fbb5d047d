//! The scene's tables, and which of them are bound as uniforms.

use std::borrow::Cow;
use std::collections::BTreeMap;

use crate::flatten::DeviceScene;
use crate::shape::{self, KINDS, ShapeKind};

/// Where the scene's tables live. Small ones fit a uniform binding, which software drivers read several times as fast as
/// a storage binding; real GPUs serialise lanes that read a uniform at different places.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct UniformTables {
    /// Elements of the uniform array, by the table's name; the others are storage.
    pub(super) uniform: BTreeMap<&'static str, u64>,
}

impl UniformTables {
    /// Puts each table that fits into so many bytes into a uniform binding; 0 puts none there.
    pub fn new(flat: &DeviceScene, uniform_bytes: u64) -> UniformTables {
        let fits = |(name, bytes, stride): (&'static str, u64, u64)| {
            let elements = (bytes / stride).max(1).next_power_of_two().min(uniform_bytes / stride);
            (elements * stride >= bytes.max(1)).then_some((name, elements))
        };
        UniformTables {
            uniform: tables(flat)
                .into_iter()
                .map(|(name, bytes, stride, _)| (name, bytes.len() as u64, stride))
                .filter_map(fits)
                .collect(),
        }
    }
}

/// A table: its name, its contents, the bytes of an element, and its purpose.
pub type Table<'a> = (&'static str, Cow<'a, [u8]>, u64, &'static str);

pub fn table<'a, T: bytemuck::Pod>(name: &'static str, items: &'a [T], why: &'static str) -> Table<'a> {
    (name, Cow::Borrowed(bytemuck::cast_slice(items)), size_of::<T>() as u64, why)
}

/// The scene's tables.
pub fn tables(flat: &DeviceScene) -> Vec<Table<'_>> {
    let shape = |kind: &'static ShapeKind| {
        let shape::Table { name, why, stride, bytes, .. } = kind.table;
        (name, Cow::Borrowed(bytes(&flat.shapes)), stride as u64, why)
    };
    let nodes = table("nodes", &flat.nodes, "the bounding volume hierarchy");
    let others = [
        table("media", &flat.media, "participating media"),
        table("lights", &flat.lights, "lights that are sampled"),
        table("delta_lights", &flat.delta_lights, "lights without size"),
        table("light_nodes", &flat.light_nodes, "the tree over them"),
        table("materials", &flat.materials, "materials"),
        table("textures", &flat.textures, "textures"),
        table("frames", &flat.frames, "where textured objects stand in their textures"),
    ];
    std::iter::once(nodes).chain(KINDS.iter().map(shape)).chain(others).collect()
}

//! The scene's tables, and which of them are bound as uniforms.

use std::borrow::Cow;
use std::collections::BTreeMap;

use crate::flatten::DeviceScene;
use crate::gpu::device::DeviceClass;
use crate::shape::{self, KINDS, ShapeKind};

/// The uniforms of a kernel other than tables: `settings` and `window`.
const OTHER_UNIFORMS: u32 = 2;

/// The address spaces of the scene's tables. Small ones fit a uniform binding, which software drivers read several times as fast as
/// a storage binding; real GPUs serialise lanes that read a uniform at different indices.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct UniformTables {
    /// Elements of the uniform array, by the table's name. Other tables are storage.
    pub(super) uniform: BTreeMap<&'static str, u64>,
}

impl UniformTables {
    /// Puts each table that fits into the uniform bindings of a device of this class. If there are more tables than bindings, the
    /// empty ones are the first to stay in storage.
    pub fn new(flat: &DeviceScene, device: DeviceClass) -> UniformTables {
        let (empty, filled): (Vec<_>, Vec<_>) = sizes(flat).into_iter().partition(|table| table.1 == 0);
        UniformTables::of(filled.into_iter().chain(empty), device.table_bytes(), most_tables(device))
    }

    /// Puts the smallest of these tables into uniform bindings, so many at most. For devices that allow a kernel few storage bindings.
    pub fn smallest(flat: &DeviceScene, device: DeviceClass, bound: &[&str], count: usize) -> UniformTables {
        let mut sizes = sizes(flat);
        sizes.retain(|(name, ..)| bound.contains(name));
        sizes.sort_by_key(|table| table.1);
        UniformTables::of(sizes.into_iter(), device.max_uniform_bytes, count)
    }

    fn of(tables: impl Iterator<Item = Sizes>, uniform_bytes: u64, most: usize) -> UniformTables {
        let fits = |(name, bytes, stride): Sizes| {
            let elements = (bytes / stride).max(1).next_power_of_two().min(uniform_bytes / stride);
            (elements * stride >= bytes.max(1)).then_some((name, elements))
        };
        UniformTables { uniform: tables.filter_map(fits).take(most).collect() }
    }
}

/// The most tables that a kernel can bind as uniforms.
pub fn most_tables(device: DeviceClass) -> usize {
    device.max_uniforms.saturating_sub(OTHER_UNIFORMS) as usize
}

/// The name of a table, its bytes, and those of an element.
type Sizes = (&'static str, u64, u64);

fn sizes(flat: &DeviceScene) -> Vec<Sizes> {
    tables(flat).iter().map(|(name, bytes, stride, _)| (*name, bytes.len() as u64, *stride)).collect()
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
        table("fields", &flat.fields, "how the densities of media vary"),
        table("lights", &flat.lights, "lights that are sampled"),
        table("delta_lights", &flat.delta_lights, "lights without size"),
        table("light_nodes", &flat.light_nodes, "the tree over them"),
        table("emitters", &flat.emitters, "lights as the starts of light paths"),
        table("aims", &flat.aims, "boxes at which light paths are aimed"),
        table("materials", &flat.materials, "materials"),
        table("textures", &flat.textures, "textures"),
        table("frames", &flat.frames, "where textured objects stand in their textures"),
    ];
    std::iter::once(nodes).chain(KINDS.iter().map(shape)).chain(others).collect()
}

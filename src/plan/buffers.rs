//! The buffers of a plan, with the scene's data for those that hold it.

use std::borrow::Cow;

use super::state::path_layout;
use super::tables::{Table, table, tables};
use super::{Kernels, Tuning};
use crate::bitmap::{self, FORMATS};
use crate::data::{self, QUEUE_HEADER};
use crate::film;
use crate::flatten::DeviceScene;
use crate::gpu::buffers::BufferSpec;
use crate::printable::counted;

impl Kernels {
    /// The buffers that the kernels bind, with the scene's data for those that hold it.
    pub(super) fn buffers<'a>(&self, flat: &'a DeviceScene, tuning: &Tuning) -> Vec<BufferSpec<'a>> {
        let slots = u64::from(tuning.slots);
        let queues = self.queues();
        let (runs, record_bytes) = (u64::from(tuning.records_per_slot), film::record_bytes(&self.aovs));
        let (tile, pixel_bytes) = (u64::from(tuning.tile), film::device_bytes(&self.aovs, self.light_paths));
        let layout = path_layout(&self.path_fields);
        let (plane_bytes, word_bytes) = (layout.plane_bytes(), layout.word_bytes());
        let header = u64::from(QUEUE_HEADER);
        let mattes = self.aovs.mattes().len().max(1) as u64;
        let array = |(name, contents, stride, why): Table<'a>| {
            let spec = BufferSpec::scene(name, vec![contents], why);
            let size = format!("{} x {stride} bytes", spec.bytes / stride);
            spec.made_of(size)
        };
        let texels = flat.texel_words().map(|words| Cow::Borrowed(bytemuck::cast_slice(words)));
        let images = flat.images.iter().map(|(_, bitmap)| ((bitmap.width, bitmap.height), bitmap.bytes()));
        let all = [
            BufferSpec::uniform("settings", self.settings.size(), "camera, sky and limits of the render"),
            BufferSpec::uniform("window", size_of::<data::Window>() as u64, "the runs that may start now"),
            BufferSpec::working(
                "counters",
                size_of::<data::Counters>() as u64,
                "runs started, idle slots, samples and rays",
            ),
            BufferSpec::working("records", slots * runs * record_bytes, "finished runs on their way to the film")
                .made_of(format!("{slots} slots x {runs} runs x {record_bytes} bytes")),
            BufferSpec::working("film", tile * pixel_bytes, "sums of each pixel's samples")
                .made_of(format!("{tile} pixels x {pixel_bytes} bytes")),
            BufferSpec::working("paths", slots * plane_bytes, "the state of the paths in flight")
                .made_of(format!("{slots} slots x {plane_bytes} bytes")),
            BufferSpec::working("path_words", slots * word_bytes, "the part of that state that fills no vec4")
                .made_of(format!("{slots} slots x {word_bytes} bytes")),
            BufferSpec {
                size: make_up_of_texels(flat),
                remedy: largest_images(flat),
                largest: images.max_by_key(|(_, bytes)| *bytes),
                ..BufferSpec::scene("texels", texels.collect(), "images")
            },
            array(table("sky", &flat.sky, "the background's image as a distribution of directions")),
            array(table("extensions", &flat.extensions, "extensions of materials")),
            array(table(
                "directional_albedos",
                &flat.directional_albedos,
                "directional albedos of rough metals by single scattering",
            )),
            array(table("light_groups", &flat.groups_of_lights, "the groups of lights")),
            array((
                "matte_ids",
                Cow::Borrowed(bytemuck::cast_slice(&flat.matte_ids)),
                4 * mattes,
                "ids of mattes by object",
            )),
            array(table("bricks", &flat.bricks, "grids of media")),
            array(table("motions", &flat.motions, "how objects move while the shutter is open")),
            array(table("meshes", &flat.meshes, "faces and vertices of meshes")),
            array(table("face_pairs", &flat.face_pairs, "faces of meshes as walks read them")),
            BufferSpec::working("queues", (header + queues * slots) * 4, "a queue for each material")
                .made_of(format!("({queues} queues x {slots} slots + {header}) x 4 bytes")),
            BufferSpec::indirect("queue_args", queues * 16, "sizes of the queues' dispatches")
                .made_of(format!("{queues} queues x 16 bytes")),
        ];
        let of_scene = |(name, contents, stride, why): Table<'a>| match self.tables.uniform.get(name) {
            Some(elements) => {
                let count = contents.len() as u64 / stride;
                let room = if *elements > count { format!(", room for {elements}") } else { String::new() };
                BufferSpec::table(name, contents, elements * stride, why)
                    .made_of(format!("{count} x {stride} bytes{room}"))
            }
            None => array((name, contents, stride, why)),
        };
        let tables = tables(flat).into_iter().map(of_scene);
        let kernels = self.all();
        let bound = |spec: &BufferSpec| kernels.iter().any(|kernel| kernel.bindings.contains_key(spec.name));
        all.into_iter().chain(tables).filter(bound).collect()
    }
}

/// The number of images of each format, and their bytes.
fn make_up_of_texels(flat: &DeviceScene) -> String {
    let of_format = |(number, name): (usize, &&str)| {
        let images = flat.images.iter().filter(|(_, bitmap)| bitmap.format.number() == number);
        let (count, bytes) = images.fold((0, 0), |(count, bytes), (_, bitmap)| (count + 1, bytes + bitmap.bytes()));
        (count > 0).then(|| format!("{}, {bytes} bytes", counted(count, &format!("{name} image"))))
    };
    let formats: Vec<String> = FORMATS.iter().enumerate().filter_map(of_format).collect();
    if formats.is_empty() { "no image".to_string() } else { formats.join("; ") }
}

/// What to do if images take too much memory.
fn largest_images(flat: &DeviceScene) -> Option<String> {
    let images = flat.images.iter();
    let images = images.map(|(path, bitmap)| (path.as_str(), (bitmap.width, bitmap.height), bitmap.bytes()));
    (!flat.images.is_empty()).then(|| format!("scale images down, the largest first: {}", bitmap::largest(images)))
}

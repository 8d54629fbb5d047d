//! What this scene requires: which kernels, linked from which modules, and which buffers, each with the reason.

mod report;
mod state;
mod text;
mod tuning;

use std::borrow::Cow;
use std::collections::BTreeMap;

use crate::data::{self, QUEUE_HEADER, RUN_LENGTH};
use crate::error::Result;
use crate::film::RunRecord;
use crate::flatten::{BACKGROUNDS, BOUNDARIES, DeviceScene, Features, MATERIALS, PRIMITIVES, TEXTURES};
use crate::gpu::buffers::BufferSpec;
use crate::gpu::device::DeviceClass;
use crate::gpu::layout::{self, Binding, Member};
use crate::gpu::link::{Choices, Embedded, Entry, Linked, link};
use crate::job::Job;
use crate::material::Material;
use crate::options::{self, FeatureSet, RenderOptions, Scatter};
use crate::shape::{KINDS, Kind, Table};

pub use report::{Buffer, Choice, Constant, KernelReport, Module, Report};
pub use state::{MOST_PATH_BYTES, PathField};
use state::{path_fields, places};
pub use tuning::Tuning;

/// The reason of what no scene can do without.
const EVERY_RENDER: &str = "every render";
/// The reason of what sorts slots into queues.
const QUEUES: &str = "--scatter queues";
/// The reason of what stages hand to each other where they are kernels of their own.
const A_KERNEL_A_STAGE: &str = "a kernel a stage";

/// The override constants that say how many steps walks may take.
pub const STEPS: [&str; 2] = ["MOST_STEPS_OF_WALK", "MOST_STEPS_OF_CROSSINGS"];

/// Where the scene's tables live. Small ones fit a uniform binding, which software drivers read several times as fast as
/// a storage binding; real GPUs serialise lanes that read a uniform at different places.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tables {
    /// Elements of the uniform array, by the table's name; the others are storage.
    uniform: BTreeMap<&'static str, u64>,
}

impl Tables {
    /// Puts each table that fits into so many bytes into a uniform binding; 0 puts none there.
    pub fn new(flat: &DeviceScene, uniform_bytes: u64) -> Tables {
        let fits = |(name, bytes, stride): (&'static str, u64, u64)| {
            let elements = (bytes / stride).max(1).next_power_of_two().min(uniform_bytes / stride);
            (elements * stride >= bytes.max(1)).then_some((name, elements))
        };
        Tables {
            uniform: tables(flat)
                .into_iter()
                .map(|(name, bytes, stride, _)| (name, bytes.len() as u64, stride))
                .filter_map(fits)
                .collect(),
        }
    }
}

/// The scene's tables: name, contents, bytes of an element, purpose.
fn tables(flat: &DeviceScene) -> Vec<(&'static str, Cow<'_, [u8]>, u64, &'static str)> {
    fn table<'a, T: bytemuck::Pod>(
        name: &'static str,
        items: &'a [T],
        why: &'static str,
    ) -> (&'static str, Cow<'a, [u8]>, u64, &'static str) {
        (name, Cow::Borrowed(bytemuck::cast_slice(items)), size_of::<T>() as u64, why)
    }
    let shape = |kind: &'static Kind| {
        let Table { name, why, stride, bytes, .. } = kind.table;
        (name, Cow::Borrowed(bytes(&flat.shapes)), stride as u64, why)
    };
    let nodes = table("nodes", &flat.nodes, "the bounding volume hierarchy");
    let others = [
        table("media", &flat.media, "participating media"),
        table("lights", &flat.lights, "lights that are sampled"),
        table("light_nodes", &flat.light_nodes, "the tree over them"),
        table("materials", &flat.materials, "materials"),
        table("textures", &flat.textures, "textures"),
        table("frames", &flat.frames, "where textured objects stand in their textures"),
    ];
    std::iter::once(nodes).chain(KINDS.iter().map(shape)).chain(others).collect()
}

/// A kernel: a linked shader and what it binds.
#[derive(Debug)]
pub struct Kernel {
    /// `scatter_metal` where it serves one material alone, else the stage's name.
    pub name: String,
    /// The entry point, and the file under shaders/stage.
    pub stage: &'static str,
    /// What it was linked with.
    pub choices: Choices,
    pub linked: Linked,
    pub module: naga::Module,
    pub bindings: BTreeMap<String, Binding>,
    /// What of the scene asked for it.
    pub why: String,
}

/// What a render of a scene takes: kernels, buffers and sizes.
#[derive(Debug)]
pub struct Plan<'a> {
    pub scene: &'a DeviceScene,
    pub options: RenderOptions,
    pub kernels: Kernels,
    pub tuning: Tuning,
}

/// The kernels of one render.
#[derive(Debug)]
pub struct Kernels {
    pub generate: Kernel,
    pub bounce: Bounce,
    /// What slots keep of their paths from one dispatch to the next.
    pub path_fields: Vec<PathField>,
    pub settings: SettingsLayout,
    /// What they are linked for.
    pub features: Features,
    tables: Tables,
}

/// The settings as the kernels of a plan have them: just the members that they need.
#[derive(Clone, Debug)]
pub struct SettingsLayout(Vec<Member>);

impl SettingsLayout {
    pub fn of(module: &naga::Module) -> Result<SettingsLayout> {
        Ok(SettingsLayout(layout::members(module, "Settings")?.map_or_else(Vec::new, |(members, _)| members)))
    }

    /// How many they are with their padding.
    fn size(&self) -> u64 {
        u64::from(layout::packed_bytes(&self.0))
    }

    /// Each member in its place, by its name.
    pub fn bytes(&self, settings: &data::Settings) -> Vec<u8> {
        layout::pack(&self.0, data::Settings::FIELDS, bytemuck::bytes_of(settings))
    }
}

/// From a ray to what becomes of it.
#[derive(Debug)]
pub enum Bounce {
    Fused(Box<Kernel>),
    Staged(Box<Staged>),
}

/// The stages of a bounce as kernels of their own.
#[derive(Debug)]
pub struct Staged {
    pub intersect: Kernel,
    /// Media on the way to what a ray met; absent where there are none.
    pub medium: Option<Kernel>,
    /// Sizes the scatter dispatches; absent where one linked kernel serves all slots.
    pub dispatch: Option<Kernel>,
    /// One linked kernel, or one for each queue in the queues' order; none where there is nothing to hit.
    pub scatter: Vec<Kernel>,
    /// Rays to lights; absent where there is none to sample.
    pub shadow: Option<Kernel>,
    pub refill: Kernel,
}

impl<'a> Plan<'a> {
    /// Decides on the kernels, the buffers and the sizes for a device of this class, and links the kernels.
    ///
    /// # Errors
    /// As of [`Kernels::link`].
    pub fn new(scene: &'a DeviceScene, options: &RenderOptions, device: DeviceClass, job: &Job) -> Result<Plan<'a>> {
        let tuning = Tuning::new(device, job, options);
        let tables = Tables::new(scene, device.table_bytes());
        let features = scene.features.of(options);
        let kernels = Kernels::link(&features, options, tuning.scatter, &tables)?;
        Ok(Plan { scene, options: options.clone(), kernels, tuning })
    }

    /// The most radiance of a contribution of indirect light, in device radiance; 0 where it is not limited.
    pub fn indirect_limit(&self) -> f32 {
        let Some(limit) = self.options.clamp else { return 0.0 };
        // Beyond what f32 holds it is as good as the least or the most.
        let device = limit * 2f64.powi(-self.scene.radiance_exponent);
        device.clamp(f64::from(f32::MIN_POSITIVE), f64::from(f32::MAX)) as f32
    }

    /// The kernels in the order in which a pass runs them.
    pub fn kernels(&self) -> Vec<&Kernel> {
        self.kernels.all()
    }

    /// The buffers that the kernels bind, with the scene's data for those that hold it.
    pub fn buffers(&self) -> Vec<BufferSpec<'a>> {
        self.kernels.buffers(self.scene, &self.tuning)
    }
}

impl Kernels {
    /// Decides and links the kernels.
    ///
    /// # Errors
    /// `Error::Shader` where a kernel does not link or validate: a defect of gpu-rt, not of the scene.
    pub fn link(features: &Features, options: &RenderOptions, scatter: Scatter, tables: &Tables) -> Result<Kernels> {
        let materials = entries(MATERIALS, &features.materials);
        let empty = materials.is_empty();
        // A queue each is no use where there is one material.
        let queues = scatter == Scatter::Queues && materials.len() > 1;
        let fused = scatter == Scatter::Fused;
        let choices = choices(features, options, &materials, Bounces { fused, queues }, tables);
        let always = EVERY_RENDER;
        let geometry = asked(PRIMITIVES, &features.primitives, "");
        let media = asked(&boundary_names(), &features.boundaries, " medium");
        let lights = features.lights > 0;
        let of_sky = asked(&["sky"], std::slice::from_ref(&features.emitting_sky), " light");
        let emitters = [asked(PRIMITIVES, &features.emitters, " light"), of_sky];
        let emitters = emitters.into_iter().filter(|why| !why.is_empty()).collect::<Vec<_>>().join(", ");
        let all_materials = asked(MATERIALS, &features.materials, "");
        let reasons = [&geometry, &all_materials, &media, &emitters];
        let all_reasons = reasons.into_iter().filter(|why| !why.is_empty()).cloned().collect::<Vec<_>>().join("; ");
        let bounce = if fused {
            let why = if all_reasons.is_empty() { always } else { &all_reasons };
            Bounce::Fused(Box::new(kernel("bounce", "bounce", &choices, why)?))
        } else {
            let if_any = |wanted: bool, name: &str, stage, why: &str| {
                wanted.then(|| kernel(name, stage, &choices, why)).transpose()
            };
            Bounce::Staged(Box::new(Staged {
                intersect: kernel("intersect", "intersect", &choices, if empty { always } else { &geometry })?,
                medium: if_any(features.crosses_media(), "medium", "medium", &media)?,
                dispatch: if_any(queues, "dispatch", "dispatch", &format!("a queue for each material ({QUEUES})"))?,
                scatter: match queues {
                    true => queued_scatters(features, &materials, &choices)?,
                    false => if_any(!empty, "scatter", "scatter", &all_materials)?.into_iter().collect(),
                },
                shadow: if_any(lights, "shadow", "shadow", &emitters)?,
                refill: kernel("refill", "refill", &choices, always)?,
            }))
        };
        let generate = kernel("generate", "generate", &choices, always)?;
        let settings = SettingsLayout::of(&generate.module)?;
        Ok(Kernels {
            generate,
            bounce,
            path_fields: path_fields(features, fused),
            settings,
            tables: tables.clone(),
            features: features.clone(),
        })
    }

    /// Bytes of the state of one slot's path.
    pub fn path_bytes(&self) -> u64 {
        self.path_fields.iter().map(PathField::bytes).sum()
    }

    /// The kernels in the order in which a pass runs them.
    pub fn all(&self) -> Vec<&Kernel> {
        let mut all = vec![&self.generate];
        match &self.bounce {
            Bounce::Fused(kernel) => all.push(kernel),
            Bounce::Staged(staged) => {
                let Staged { intersect, medium, dispatch, scatter, shadow, refill } = &**staged;
                all.extend(std::iter::once(intersect).chain(medium).chain(dispatch).chain(scatter).chain(shadow));
                all.push(refill);
            }
        }
        all
    }

    /// How many queues slots are sorted into.
    fn queues(&self) -> u64 {
        match &self.bounce {
            Bounce::Staged(staged) if staged.dispatch.is_some() => staged.scatter.len() as u64,
            _ => 0,
        }
    }

    /// The buffers that the kernels bind, with the scene's data for those that hold it.
    fn buffers<'a>(&self, flat: &'a DeviceScene, tuning: &Tuning) -> Vec<BufferSpec<'a>> {
        let slots = u64::from(tuning.slots);
        let queues = self.queues();
        let record_bytes = size_of::<RunRecord>() as u64;
        let runs = u64::from(tuning.records_per_slot);
        let places = places(&self.path_fields);
        let (plane_bytes, word_bytes) = (places.plane_bytes(), places.word_bytes());
        let header = u64::from(QUEUE_HEADER);
        let array = |name, contents: Cow<'a, [u8]>, stride: u64, why| {
            let size = format!("{} x {stride} bytes", contents.len() as u64 / stride);
            BufferSpec::scene(name, contents, why).made_of(size)
        };
        let all = [
            BufferSpec::uniform("settings", self.settings.size(), "camera, sky and limits of the render"),
            BufferSpec::uniform("window", size_of::<data::Window>() as u64, "the runs that may start now"),
            BufferSpec::working(
                "counters",
                size_of::<data::Counters>() as u64,
                "runs started and finished, idle slots",
            ),
            BufferSpec::working("records", slots * runs * record_bytes, "finished runs on their way to the film")
                .made_of(format!("{slots} slots x {runs} runs x {record_bytes} bytes")),
            BufferSpec::working("paths", slots * plane_bytes, "the state of the paths in flight")
                .made_of(format!("{slots} slots x {plane_bytes} bytes")),
            BufferSpec::working("path_words", slots * word_bytes, "what of that state fills no vec4")
                .made_of(format!("{slots} slots x {word_bytes} bytes")),
            array("texels", bytes(&flat.texels), element_bytes(&flat.texels), "images"),
            array(
                "sky",
                bytes(&flat.sky),
                element_bytes(&flat.sky),
                "the background's image as a distribution of directions",
            ),
            array("meshes", bytes(&flat.meshes), element_bytes(&flat.meshes), "faces and vertices of meshes"),
            BufferSpec::working("queues", (header + queues * slots) * 4, "a queue for each material")
                .made_of(format!("({queues} queues x {slots} slots + {header}) x 4 bytes")),
            BufferSpec::indirect("queue_args", queues * 16, "sizes of the queues' dispatches")
                .made_of(format!("{queues} queues x 16 bytes")),
        ];
        let tables =
            tables(flat).into_iter().map(|(name, contents, stride, why)| match self.tables.uniform.get(name) {
                Some(elements) => {
                    let count = contents.len() as u64 / stride;
                    let room = if *elements > count { format!(", room for {elements}") } else { String::new() };
                    BufferSpec::table(name, contents, elements * stride, why)
                        .made_of(format!("{count} x {stride} bytes{room}"))
                }
                None => array(name, contents, stride, why),
            });
        let kernels = self.all();
        let bound = |spec: &BufferSpec| kernels.iter().any(|kernel| kernel.bindings.contains_key(spec.name));
        all.into_iter().chain(tables).filter(bound).collect()
    }
}

fn bytes<T: bytemuck::Pod>(items: &[T]) -> Cow<'_, [u8]> {
    Cow::Borrowed(bytemuck::cast_slice(items))
}

fn element_bytes<T>(_: &[T]) -> u64 {
    size_of::<T>() as u64
}

/// The entries of a list of kinds that the scene uses; the last one closes a switch over them.
fn entries(names: &[&str], used: &[Option<String>]) -> Vec<Entry> {
    closed((0..).zip(names).zip(used).filter(|(_, used)| used.is_some()).map(|((number, name), _)| (*name, number)))
}

fn closed<'a>(kinds: impl Iterator<Item = (&'a str, u32)>) -> Vec<Entry> {
    let mut entries: Vec<_> =
        kinds.map(|(name, number)| Entry { name: name.to_string(), number, closes: false }).collect();
    if let Some(last) = entries.last_mut() {
        last.closes = true;
    }
    entries
}

fn boundary_names() -> Vec<&'static str> {
    BOUNDARIES.iter().map(|(name, _)| *name).collect()
}

/// "sphere light (objects.ron:3:9), quad light (…)"
fn asked(names: &[&str], used: &[Option<String>], suffix: &str) -> String {
    let each = names.iter().zip(used).filter_map(|(name, used)| Some(format!("{name}{suffix} ({})", used.as_ref()?)));
    each.collect::<Vec<_>>().join(", ")
}

/// What a kernel over all materials of the scene is linked with: for benchmarks and tests that link their own.
pub fn choices_of(features: &Features, options: &RenderOptions, tables: &Tables) -> Choices {
    choices(features, options, &entries(MATERIALS, &features.materials), Bounces { fused: true, queues: false }, tables)
}

/// How the steps of a bounce are cut into kernels.
#[derive(Clone, Copy)]
struct Bounces {
    fused: bool,
    queues: bool,
}

fn choices(
    features: &Features,
    options: &RenderOptions,
    materials: &[Entry],
    bounces: Bounces,
    tables: &Tables,
) -> Choices {
    let Bounces { fused, queues } = bounces;
    let textures = entries(TEXTURES, &features.textures);
    let backgrounds = entries(BACKGROUNDS, &features.backgrounds);
    let (own_background, other_backgrounds) = match backgrounds.split_last() {
        Some((own, others)) => (vec![own.clone()], others.to_vec()),
        None => (Vec::new(), Vec::new()),
    };
    let walk = match features {
        _ if materials.is_empty() => "scene/nothing",
        Features { brute_force: true, .. } => "scene/brute_force",
        _ => "scene/traverse",
    };
    let image_texture = textures.iter().any(|texture| texture.name == "image");
    let pick = |condition, yes, no| if condition { yes } else { no };
    // The faces of meshes are tested, told apart and shaded beside the other primitives; `mesh` is a list of its own, so that
    // what meshes alone need stands in the same files. So it is with lights and with boundaries of media.
    let of_meshes = |entry: &Entry| [data::KIND_TRIANGLE, data::KIND_INSTANCE].contains(&entry.number);
    let split = |all: Vec<Entry>| all.into_iter().partition::<Vec<_>, _>(of_meshes);
    let (meshes, primitives) = split(entries(PRIMITIVES, &features.primitives));
    let (emitting_meshes, emitters) = split(entries(PRIMITIVES, &features.emitters));
    let boundaries = BOUNDARIES.iter().zip(&features.boundaries).filter(|(_, used)| used.is_some());
    let (mesh_boundaries, convex_boundaries) = split(closed(boundaries.map(|(boundary, _)| *boundary)));
    let media = features.crosses_media();
    let lights = features.lights > 0;
    // One entry or none: what is linked where there are lights, and of which kinds.
    let only_if = |wanted: bool, name: &str| if wanted { closed(std::iter::once((name, 0))) } else { Vec::new() };
    let one_way = one_way(features);
    let places = places(&path_fields(features, fused));
    let numbered = |all: &[(&'static str, u32)]| closed(all.iter().copied());
    let surfaces = !materials.is_empty();
    let has_events = surfaces || features.media > 0;
    let clamps = options.clamp.is_some() && has_events;
    let has_glass = materials.iter().any(|material| material.name == "dielectric");
    let is_sphere = |entry: &Entry| entry.name == "sphere";
    let has_spheres = primitives.iter().chain(&convex_boundaries).any(is_sphere);
    let mut choices = Choices {
        modules: BTreeMap::from([
            ("axes", pick(features.turned.is_some(), "scene/camera_axes", "scene/world_axes")),
            ("camera", pick(features.thin_lens.is_some(), "camera/thin_lens", "camera/pinhole")),
            ("colour", pick(textures.is_empty(), "scene/plain_colour", "scene/textured_colour")),
            ("uv", pick(image_texture, "scene/uv", "scene/no_uv")),
            ("shading", pick(features.smooth.is_some(), "scene/smooth_shading", "scene/flat_shading")),
            ("medium_albedo", pick(features.textured_media.is_some(), "scene/textured_medium", "scene/plain_medium")),
            ("roulette", options::ROULETTE.module(options, true).0),
            ("clamp", options::CLAMP.module(options, has_events).0),
            ("fresnel", options::FRESNEL.module(options, has_glass).0),
            ("offset", options::OFFSET.module(options, surfaces).0),
            ("sphere_chord", options::PRECISION.module(options, has_spheres).0),
            ("light_choice", pick(features.lights > 1, "scene/light_tree", "scene/one_light")),
            ("walk", walk),
            ("sampler", options::SAMPLER.module(options, true).0),
        ]),
        lists: BTreeMap::from([
            ("primitive", primitives),
            ("mesh", meshes),
            ("light", only_if(lights, "light")),
            ("staged_light", only_if(lights && !fused, "light")),
            ("medium", only_if(media, "medium")),
            ("queue", only_if(queues, "queue")),
            // Slots are sorted when it is known what becomes of their rays: after the media, where there are any.
            ("queue_of_hits", only_if(queues && !media, "queue")),
            ("surface", only_if(surfaces, "surface")),
            ("event", only_if(surfaces || media, "event")),
            ("lens", only_if(features.thin_lens.is_some(), "lens")),
            ("camera_axes", only_if(features.turned.is_some(), "camera_axes")),
            ("clamp", only_if(clamps, "clamp")),
            ("brute_force", only_if(walk == "scene/brute_force", "brute_force")),
            ("gradient_background", only_if(features.backgrounds[1].is_some(), "gradient")),
            ("image_background", only_if(features.backgrounds[2].is_some(), "image")),
            ("background", backgrounds),
            ("several_backgrounds", only_if(!other_backgrounds.is_empty(), "several")),
            ("own_background", own_background),
            ("other_background", other_backgrounds),
            ("path_plane", numbered(&places.planes)),
            ("path_word", numbered(&places.words)),
            ("other_path_word", numbered(&places.others)),
            ("emitter", emitters),
            ("emitting_mesh", emitting_meshes),
            ("emitting_surface", only_if(features.emitters.iter().any(Option::is_some), "surface")),
            ("unsampled", only_if(features.unsampled.is_some() || options.features == FeatureSet::All, "unsampled")),
            ("emitting_sky", only_if(features.emitting_sky.is_some(), "sky")),
            ("one_way", only_if(one_way, "one_way")),
            ("sky_by_chance", only_if(one_way && features.emitting_sky.is_some(), "sky")),
            ("convex_boundary", convex_boundaries),
            ("mesh_boundary", mesh_boundaries),
            ("texture", textures),
        ]),
        values: TABLES
            .iter()
            .copied()
            .chain(KINDS.iter().map(|kind| (kind.table.name, kind.table.space, kind.table.size)))
            .flat_map(|names| table_values(names, tables))
            .chain([
                ("stack_size", (features.stack_size + 1).to_string()),
                // A walk that looks at all children has one more waiting at each level.
                ("boundary_stack_size", (features.boundary_stack_size + 2).to_string()),
                ("media", features.media.to_string()),
                ("lights", features.lights.to_string()),
                ("sky_light", features.sky_light.to_string()),
                ("sky_columns", features.sky_grid.0.to_string()),
                ("sky_rows", features.sky_grid.1.to_string()),
                // Mesa 22.3 allows an invocation 65,535 iterations: for one walk, or for two, the other being a shadow ray's.
                ("most_steps", if features.shadow_rays { "19000" } else { "48000" }.to_string()),
                ("run_length", RUN_LENGTH.to_string()),
                ("queues", materials.len().to_string()),
            ])
            .collect(),
    };
    serve(&mut choices, features, materials);
    choices
}

/// Whether lights are sampled, and mirrors or glass leave some to chance.
fn one_way(features: &Features) -> bool {
    features.lights > 0 && features.specular.iter().any(Option::is_some)
}

/// What a kernel has that serves these materials.
fn serve(choices: &mut Choices, features: &Features, materials: &[Entry]) {
    let lights = features.lights > 0;
    let only_if = |wanted: bool, name: &str| if wanted { closed(std::iter::once((name, 0))) } else { Vec::new() };
    let is_in = |used: &[Option<String>], entry: &Entry| used.get(entry.number as usize).is_some_and(Option::is_some);
    let non_specular: Vec<Entry> =
        materials.iter().filter(|entry| is_in(&features.non_specular, entry)).cloned().collect();
    let answers = lights && !non_specular.is_empty();
    let specular = lights && materials.iter().any(|entry| is_in(&features.specular, entry));
    let shines =
        materials.iter().any(|entry| Material::KINDS.get(entry.number as usize).is_some_and(|kind| kind.emits));
    let sampled = features.emitters.iter().any(Option::is_some);
    choices.lists.extend([
        ("surface_samples_light", only_if(answers, "surface_samples_light")),
        ("specular", only_if(specular, "specular")),
        ("sends_shadow_ray", only_if(answers || specular, "sends_shadow_ray")),
        ("met_light", only_if(lights && sampled && shines, "light")),
        ("met_by_chance", only_if(one_way(features) && sampled && shines, "light")),
        ("non_specular", non_specular),
        ("material", materials.to_vec()),
    ]);
}

/// The tables but those of shapes by name, and the names of the values that say how each is bound.
const TABLES: [(&str, &str, &str); 7] = [
    ("nodes", "space_of_nodes", "size_of_nodes"),
    ("media", "space_of_media", "size_of_media"),
    ("lights", "space_of_lights", "size_of_lights"),
    ("light_nodes", "space_of_light_nodes", "size_of_light_nodes"),
    ("materials", "space_of_materials", "size_of_materials"),
    ("textures", "space_of_textures", "size_of_textures"),
    ("frames", "space_of_frames", "size_of_frames"),
];

/// The address space of a table's binding, and the size of its array.
fn table_values(
    (name, space, size): (&'static str, &'static str, &'static str),
    tables: &Tables,
) -> [(&'static str, String); 2] {
    match tables.uniform.get(name) {
        Some(elements) => [(space, "uniform".to_string()), (size, format!(", {elements}"))],
        None => [(space, "storage, read".to_string()), (size, String::new())],
    }
}

/// A scatter kernel for each material: the linked kernel's own file with a list of one.
fn queued_scatters(features: &Features, materials: &[Entry], choices: &Choices) -> Result<Vec<Kernel>> {
    (0..)
        .zip(materials)
        .map(|(queue, material)| {
            let mut own = choices.clone();
            serve(&mut own, features, &[Entry { closes: true, ..material.clone() }]);
            own.values.insert("queue", i32::to_string(&queue));
            let why = features.materials[material.number as usize].clone().unwrap_or_default();
            kernel(&format!("scatter_{}", material.name), "scatter", &own, &why)
        })
        .collect()
}

fn kernel(name: &str, stage: &'static str, choices: &Choices, why: &str) -> Result<Kernel> {
    let linked = link(&Embedded, &format!("stage/{stage}"), choices)?;
    let (module, _) = linked.validate()?;
    let bindings = layout::bindings(&module)?;
    let choices = choices.clone();
    Ok(Kernel { name: name.to_string(), stage, choices, linked, module, bindings, why: why.to_string() })
}

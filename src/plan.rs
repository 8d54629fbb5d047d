//! What this scene requires: which kernels, linked from which modules, and which buffers, each with the reason.

pub mod choices;
mod report;
mod state;
mod tables;
mod text;
mod tuning;

use std::borrow::Cow;
use std::collections::BTreeMap;

use crate::aov::Aovs;
use crate::bitmap::{self, FORMATS};
use crate::bvh::Quality;
use crate::data::{self, QUEUE_HEADER};
use crate::error::Result;
use crate::film;
use crate::flatten::{BOUNDARIES, DeviceScene, Features, MATERIALS, PRIMITIVES};
use crate::gpu::buffers::BufferSpec;
use crate::gpu::device::DeviceClass;
use crate::gpu::layout::{self, Binding, Member};
use crate::gpu::link::{Choices, Embedded, Entry, Linked, Reason, link};
use crate::job::Job;
use crate::options::{RenderOptions, Scatter};

use choices::{Bounces, Decided, QUEUES, decide, entries, of_light_paths};
pub use report::{Buffer, Choice, Constant, KernelReport, Module, Report};
use state::path_layout;
pub use state::{PathField, most_path_bytes};
pub use tables::UniformTables;
use tables::{Table, table, tables};
pub use tuning::Tuning;

/// The override constants that say how many steps walks may take.
pub const STEPS: [&str; 2] = ["MOST_STEPS_OF_WALK", "MOST_STEPS_OF_CROSSINGS"];

/// Renders of fewer paths than this are faster with linked kernels than with a large fused one. Linked kernels compile in half of the time, and
/// render about half as many paths per second (docs/dev/performance.md).
const LONG_RENDER: u64 = 1 << 19;
/// Kernels with more expressions than this take longer to compile if they are fused.
const LARGE_KERNELS: usize = 4500;

/// A kernel: a linked shader and what it binds.
#[derive(Debug)]
pub struct Kernel {
    /// `scatter_metal` if it serves one material alone, else the stage's name.
    pub name: String,
    /// The entry point, and the file under shaders/stage.
    pub stage: &'static str,
    /// The choices that it was linked with.
    pub choices: Choices,
    pub linked: Linked,
    pub module: naga::Module,
    pub bindings: BTreeMap<String, Binding>,
    /// The objects and options that need it, in words.
    pub why: String,
    /// The reason for the kernel, if only some scenes have it; else every render.
    pub reason: Reason,
}

/// The plan of a render: its kernels, buffers and sizes.
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
    /// Adds finished runs to the film, after some bounces.
    pub accumulate: Kernel,
    /// Ends a submission.
    pub receipt: Kernel,
    /// Light paths; absent if none are traced.
    pub light_path: Option<Kernel>,
    /// The state of a path that slots keep from one dispatch to the next.
    pub path_fields: Vec<PathField>,
    pub settings: SettingsLayout,
    /// The channels of `--aov`.
    pub aovs: Aovs,
    /// Whether there are light paths.
    pub light_paths: bool,
    /// The features that they are linked for.
    pub features: Features,
    tables: UniformTables,
}

/// The members of `Settings` that the kernels of a plan use.
#[derive(Clone, Debug)]
pub struct SettingsLayout(Vec<Member>);

impl SettingsLayout {
    pub fn from_module(module: &naga::Module) -> Result<SettingsLayout> {
        Ok(SettingsLayout(layout::members(module, "Settings")?.map_or_else(Vec::new, |(members, _)| members)))
    }

    /// Bytes of the settings, with padding.
    fn size(&self) -> u64 {
        u64::from(layout::packed_bytes(&self.0))
    }

    /// The bytes of the settings, with each member at the offset that it has in the kernels.
    pub fn bytes(&self, settings: &data::Settings) -> Vec<u8> {
        layout::pack(&self.0, data::Settings::FIELDS, bytemuck::bytes_of(settings))
    }
}

/// The kernels of a bounce.
#[derive(Debug)]
pub enum Bounce {
    Fused(Box<Kernel>),
    Staged(Box<Staged>),
}

/// A kernel for each stage of a bounce.
#[derive(Debug)]
pub struct Staged {
    pub intersect: Kernel,
    /// Samples events in media before the hit; absent if there are no media.
    pub medium: Option<Kernel>,
    /// Sizes the scatter dispatches; absent if one linked kernel serves all slots.
    pub dispatch: Option<Kernel>,
    /// One linked kernel, or one for each queue in the queues' order; none if the scene has no surface.
    pub scatter: Vec<Kernel>,
    /// Traces shadow rays; absent if no light is sampled.
    pub shadow: Option<Kernel>,
    pub refill: Kernel,
}

impl<'a> Plan<'a> {
    /// Chooses the kernels, the buffers and the sizes for a device of this class, and links the kernels.
    ///
    /// # Errors
    /// As of [`Kernels::link`].
    pub fn new(scene: &'a DeviceScene, options: &RenderOptions, device: DeviceClass, job: &Job) -> Result<Plan<'a>> {
        let options = &RenderOptions { light_paths: scene.light_paths(options), ..options.clone() };
        let mut tuning = Tuning::new(device, job, options);
        let tables = UniformTables::new(scene, device);
        let features = scene.features.with_options(options);
        let mut kernels = Kernels::link(&features, options, tuning.scatter, &tables)?;
        let is_short = options.scatter.is_none() && job.paths().is_some_and(|paths| paths < LONG_RENDER);
        if is_short && tuning.scatter == Scatter::Fused && kernels.expressions() > LARGE_KERNELS {
            (tuning.scatter, tuning.is_short) = (Scatter::Linked, true);
            kernels = Kernels::link(&features, options, tuning.scatter, &tables)?;
        }
        Ok(Plan { scene, options: options.clone(), kernels, tuning })
    }

    /// The limit of `--clamp` on a contribution of indirect light, in device radiance; 0 without it.
    pub fn indirect_limit(&self) -> f32 {
        let Some(limit) = self.options.clamp else { return 0.0 };
        // Values beyond the range of f32 become its least or largest.
        let device = limit * 2f64.powi(-self.scene.radiance_exponent);
        device.clamp(f64::from(f32::MIN_POSITIVE), f64::from(f32::MAX)) as f32
    }

    /// The kernels in the order in which a pass runs them.
    pub fn kernels(&self) -> Vec<&Kernel> {
        self.kernels.all()
    }

    /// The buffers that the kernels bind, with the scene's data for those that hold it.
    pub fn buffers(&self) -> Vec<BufferSpec<'a>> {
        let with_remedy = |spec: BufferSpec<'a>| match spec.name {
            "nodes" if self.options.build == Quality::Best => {
                spec.shrunk_by(Some("`--build medium` makes fewer".to_string()))
            }
            _ => spec,
        };
        self.kernels.buffers(self.scene, &self.tuning).into_iter().map(with_remedy).collect()
    }
}

impl Kernels {
    /// The number of expressions in all functions of all kernels.
    fn expressions(&self) -> usize {
        let of = |kernel: &Kernel| {
            kernel.module.functions.iter().map(|(_, function)| function.expressions.len()).sum::<usize>()
        };
        self.all().into_iter().map(of).sum()
    }

    /// Chooses and links the kernels.
    ///
    /// # Errors
    /// `Error::Shader` if a kernel does not link or validate: a defect of gpu-rt, not of the scene.
    pub fn link(
        features: &Features,
        options: &RenderOptions,
        scatter: Scatter,
        tables: &UniformTables,
    ) -> Result<Kernels> {
        let materials = entries(MATERIALS, &features.materials);
        // With one material there is nothing to sort.
        let queues = scatter == Scatter::Queues && materials.len() > 1;
        let fused = scatter == Scatter::Fused;
        let bounces = Bounces { fused, queues };
        let decided = decide(features, options, tables, &materials, &materials, 0, bounces);
        let Decided { choices, path_fields, surface, medium, light, queue, light_paths } = decided;
        let always = |name, why: &str| kernel(name, name, &choices, why, &Reason::EveryRender);
        let every_render = Reason::EveryRender.to_string();
        let geometry = names_with_reasons(PRIMITIVES, &features.primitives, "");
        let media = names_with_reasons(&boundary_names(), &features.boundaries, " medium");
        let of_sky = names_with_reasons(&["sky"], std::slice::from_ref(&features.emitting_sky), " light");
        let without_size = names_with_reasons(&["delta"], std::slice::from_ref(&features.delta_lights), " light");
        let emitters = [names_with_reasons(PRIMITIVES, &features.emitters, " light"), without_size, of_sky];
        let emitters = emitters.into_iter().filter(|why| !why.is_empty()).collect::<Vec<_>>().join(", ");
        let all_materials = names_with_reasons(MATERIALS, &features.materials, "");
        let reasons = [&geometry, &all_materials, &media, &emitters];
        let all_reasons = reasons.into_iter().filter(|why| !why.is_empty()).cloned().collect::<Vec<_>>().join("; ");
        let bounce = if fused {
            Bounce::Fused(Box::new(always(
                "bounce",
                if all_reasons.is_empty() { &every_render } else { &all_reasons },
            )?))
        } else {
            let if_any = |reason: &Option<Reason>, name, why: &str| {
                reason.as_ref().map(|reason| kernel(name, name, &choices, why, reason)).transpose()
            };
            // The scatter kernel of one material is the stage's file with a list of one material.
            let queued_scatter = |(queue, material): (u32, &Entry)| {
                let served = [Entry { closes: true, ..material.clone() }];
                let own = decide(features, options, tables, &materials, &served, queue, bounces).choices;
                let name = format!("scatter_{}", material.name);
                kernel(&name, "scatter", &own, &material.why.to_string(), &material.why)
            };
            Bounce::Staged(Box::new(Staged {
                intersect: always("intersect", if surface.is_none() { &every_render } else { &geometry })?,
                medium: if_any(&medium, "medium", &media)?,
                dispatch: if_any(&queue, "dispatch", &format!("a queue for each material ({QUEUES})"))?,
                scatter: match queues {
                    true => (0..).zip(&materials).map(queued_scatter).collect::<Result<_>>()?,
                    false => if_any(&surface, "scatter", &all_materials)?.into_iter().collect(),
                },
                shadow: if_any(&light, "shadow", &emitters)?,
                refill: always("refill", &every_render)?,
            }))
        };
        let generate = always("generate", &every_render)?;
        let settings = SettingsLayout::from_module(&generate.module)?;
        let accumulate = always("accumulate", &every_render)?;
        let link_light_path = |reason: &Reason| {
            kernel("light_path", "light_path", &of_light_paths(&choices), &reason.to_string(), reason)
        };
        let light_path = light_paths.as_ref().map(link_light_path).transpose()?;
        Ok(Kernels {
            generate,
            bounce,
            accumulate,
            receipt: always("receipt", &every_render)?,
            light_path,
            path_fields,
            settings,
            aovs: options.aov.clone(),
            light_paths: options.light_paths.count() > 0,
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
        all.push(&self.accumulate);
        all.extend(&self.light_path);
        all.push(&self.receipt);
        all
    }

    /// The number of queues that slots are sorted into.
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
        let (runs, record_bytes) = (u64::from(tuning.records_per_slot), film::record_bytes(&self.aovs));
        let (tile, pixel_bytes) = (u64::from(tuning.tile), film::device_bytes(&self.aovs, self.light_paths));
        let layout = path_layout(&self.path_fields);
        let (plane_bytes, word_bytes) = (layout.plane_bytes(), layout.word_bytes());
        let header = u64::from(QUEUE_HEADER);
        let array = |(name, contents, stride, why): Table<'a>| {
            let spec = BufferSpec::scene(name, vec![contents], why);
            let size = format!("{} x {stride} bytes", spec.bytes / stride);
            spec.made_of(size)
        };
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
            BufferSpec::scene(
                "texels",
                flat.texel_words().map(|words| Cow::Borrowed(bytemuck::cast_slice(words))).collect(),
                "images",
            )
            .made_of(make_up_of_texels(flat))
            .shrunk_by(largest_images(flat))
            .with_largest(flat.images.iter().map(|(_, bitmap)| ((bitmap.width, bitmap.height), bitmap.bytes()))),
            array(table("sky", &flat.sky, "the background's image as a distribution of directions")),
            array(table("extensions", &flat.extensions, "extensions of materials")),
            array(table(
                "directional_albedos",
                &flat.directional_albedos,
                "directional albedos of rough metals by single scattering",
            )),
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
        let plural = if count == 1 { "" } else { "s" };
        (count > 0).then(|| format!("{count} {name} image{plural}, {bytes} bytes"))
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

fn boundary_names() -> Vec<&'static str> {
    BOUNDARIES.iter().map(|(name, _)| *name).collect()
}

/// "sphere light (objects.ron:3:9), quad light (…)"
fn names_with_reasons(names: &[&str], used: &[Option<String>], suffix: &str) -> String {
    let each = names.iter().zip(used).filter_map(|(name, used)| Some(format!("{name}{suffix} ({})", used.as_ref()?)));
    each.collect::<Vec<_>>().join(", ")
}

/// The choices of a kernel for all materials of the scene, for benchmarks and tests that link their own.
pub fn choices_of(features: &Features, options: &RenderOptions, tables: &UniformTables) -> Choices {
    let materials = entries(MATERIALS, &features.materials);
    decide(features, options, tables, &materials, &materials, 0, Bounces { fused: true, queues: false }).choices
}

fn kernel(name: &str, stage: &'static str, choices: &Choices, why: &str, reason: &Reason) -> Result<Kernel> {
    let linked = link(&Embedded, &format!("stage/{stage}"), choices)?;
    let (module, _) = linked.validate()?;
    let bindings = layout::bindings(&module)?;
    let (name, choices, why, reason) = (name.to_string(), choices.clone(), why.to_string(), reason.clone());
    Ok(Kernel { name, stage, choices, linked, module, bindings, why, reason })
}

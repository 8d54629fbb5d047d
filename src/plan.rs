//! What this scene requires: which kernels, linked from which modules, and which buffers, each with the reason.

mod buffers;
mod choices;
mod facts;
mod report;
mod state;
mod tables;
mod text;
mod tuning;

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use crate::aov::Aovs;
use crate::bvh::Quality;
use crate::data;
use crate::error::Result;
use crate::flatten::{Declared, DeviceScene, Features};
use crate::gpu::buffers::BufferSpec;
use crate::gpu::device::DeviceClass;
use crate::gpu::layout::{self, Binding, Member};
use crate::gpu::link::{Choices, Embedded, Entry, Linked, Reason, link, reason_of};
use crate::job::Job;
use crate::options::{RenderOptions, Scatter};

use choices::{decide, materials};
pub use facts::CONDITIONS;
use facts::{Bounces, Purpose, QUEUES, known_of};
pub use report::{Buffer, Choice, Constant, KernelReport, Module, Report};
pub use state::{Code, PathField, most_path_bytes, path_layout};
pub use tables::UniformTables;
pub use tuning::Tuning;

/// The override constants that say how many steps walks may take.
pub const STEPS: [&str; 2] = ["MOST_STEPS_OF_WALK", "MOST_STEPS_OF_CROSSINGS"];

/// Renders of fewer paths than this are faster with linked kernels than with a large fused one. Linked kernels compile in half of the time, and
/// render about half as many paths per second (docs/dev/performance.md).
const LONG_RENDER: u64 = 1 << 19;
/// Kernels with more expressions than this take longer to compile if they are fused.
const LARGE_KERNELS: usize = 4500;

/// How many kernels are kept for renders that come later. A render has 15 at most.
const KEPT_KERNELS: usize = 32;

/// A kernel: a linked shader and what it binds.
#[derive(Clone, Debug)]
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
    pub generate: Arc<Kernel>,
    pub bounce: Bounce,
    /// Adds finished runs to the film, after some bounces.
    pub accumulate: Arc<Kernel>,
    /// What sample 0 sees, if it is asked for.
    pub truth: Option<Arc<Kernel>>,
    /// Ends a submission.
    pub receipt: Arc<Kernel>,
    /// Light paths; absent if none are traced.
    pub light_path: Option<Arc<Kernel>>,
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

    /// The members, for programs that write settings themselves.
    pub fn members(&self) -> &[Member] {
        &self.0
    }

    /// The bytes of the settings, with each member at the offset that it has in the kernels.
    pub fn bytes(&self, settings: &data::Settings) -> Vec<u8> {
        layout::pack(&self.0, data::Settings::FIELDS, bytemuck::bytes_of(settings))
    }
}

/// The kernels of a bounce.
#[derive(Debug)]
pub enum Bounce {
    Fused(Arc<Kernel>),
    Staged(Box<Staged>),
}

/// A kernel for each stage of a bounce.
#[derive(Debug)]
pub struct Staged {
    pub intersect: Arc<Kernel>,
    /// Samples events in media before the hit; absent if there are no media.
    pub medium: Option<Arc<Kernel>>,
    /// Sizes the scatter dispatches; absent if one linked kernel serves all slots.
    pub dispatch: Option<Arc<Kernel>>,
    /// One linked kernel, or one for each queue in the queues' order; none if the scene has no surface.
    pub scatter: Vec<Arc<Kernel>>,
    /// Traces shadow rays; absent if no light is sampled.
    pub shadow: Option<Arc<Kernel>>,
    pub refill: Arc<Kernel>,
}

impl<'a> Plan<'a> {
    /// Chooses the kernels, the buffers and the sizes for a device of this class, and links the kernels.
    ///
    /// # Errors
    /// As of [`Kernels::link`].
    pub fn new(scene: &'a DeviceScene, options: &RenderOptions, device: DeviceClass, job: &Job) -> Result<Plan<'a>> {
        let options =
            &RenderOptions { light_paths: scene.light_paths(options), aov: scene.aovs(options), ..options.clone() };
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

    /// A plan whose kernels bind so many storage buffers at most, if they can: as few of the smallest tables as are needed are uniforms.
    ///
    /// # Errors
    /// As of [`Kernels::link`].
    pub fn within(
        scene: &'a DeviceScene,
        options: &RenderOptions,
        device: DeviceClass,
        job: &Job,
        most_storage: usize,
    ) -> Result<Plan<'a>> {
        let mut plan = Plan::new(scene, options, device, job)?;
        let buffers = plan.buffers();
        let bound: Vec<&str> = buffers.iter().map(|buffer| buffer.name).collect();
        for count in 1..=tables::most_tables(device) {
            if plan.most_storage_buffers() <= most_storage {
                break;
            }
            let tables = UniformTables::smallest(scene, device, &bound, count);
            plan.kernels = Kernels::link(&plan.kernels.features, &plan.options, plan.tuning.scatter, &tables)?;
        }
        Ok(plan)
    }

    /// The most storage buffers that one of the kernels binds.
    pub fn most_storage_buffers(&self) -> usize {
        let is_storage = |binding: &&Binding| binding.kind != layout::BindingKind::Uniform;
        let of = |kernel: &Arc<Kernel>| kernel.bindings.values().filter(is_storage).count();
        self.kernels().into_iter().map(of).max().unwrap_or_default()
    }

    /// The limit of `--clamp` on a contribution of indirect light, in device radiance; 0 without it.
    pub fn indirect_limit(&self) -> f32 {
        let Some(limit) = self.options.clamp else { return 0.0 };
        // Values beyond the range of f32 become its least or largest.
        let device = limit * 2f64.powi(-self.scene.radiance_exponent);
        device.clamp(f64::from(f32::MIN_POSITIVE), f64::from(f32::MAX)) as f32
    }

    /// The settings of the scene for a job.
    pub fn settings(&self, job: &Job) -> data::Settings {
        data::Settings {
            light_paths: self.options.light_paths.count(),
            max_depth: job.max_depth,
            seed: job.seed,
            slots: self.tuning.slots,
            film_width: job.size.0,
            film_height: job.size.1,
            indirect_limit: self.indirect_limit(),
            ..self.scene.settings
        }
    }

    /// The kernels in the order in which a pass runs them.
    pub fn kernels(&self) -> Vec<&Arc<Kernel>> {
        self.kernels.all()
    }

    /// The buffers that the kernels bind, with the scene's data for those that hold it.
    pub fn buffers(&self) -> Vec<BufferSpec<'a>> {
        let with_remedy = |spec: BufferSpec<'a>| match spec.name {
            "nodes" if self.options.build == Quality::Best => {
                BufferSpec { remedy: Some("`--build medium` makes fewer".to_string()), ..spec }
            }
            _ => spec,
        };
        self.kernels.buffers(self.scene, &self.tuning).into_iter().map(with_remedy).collect()
    }
}

impl Kernels {
    /// The number of expressions in all functions of all kernels.
    fn expressions(&self) -> usize {
        let of = |kernel: &Arc<Kernel>| {
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
        let materials = materials(features);
        // With one material there is nothing to sort.
        let queues = scatter == Scatter::Queues && materials.len() > 1;
        let fused = scatter == Scatter::Fused;
        let bounces = Bounces { fused, queues };
        let choose = |served: &[Entry], queue, light_path| {
            decide(features, options, tables, &materials, queue, Purpose { served, bounces, light_path })
        };
        let (choices, path_fields) = choose(&materials, 0, false);
        let always = |name, why: &str| kernel(name, name, &choices, why, &Reason::EveryRender);
        let every_render = Reason::EveryRender.to_string();
        let geometry = names_with_reasons(features, &["shape"]);
        let media = names_with_reasons(features, &["boundary"]);
        let emitters = names_with_reasons(features, &["area_light", "delta_light", "sky_light"]);
        let all_materials = names_with_reasons(features, &["material"]);
        let reasons = [&geometry, &all_materials, &media, &emitters];
        let all_reasons = reasons.into_iter().filter(|why| !why.is_empty()).cloned().collect::<Vec<_>>().join("; ");
        let bounce = if fused {
            Bounce::Fused(always("bounce", if all_reasons.is_empty() { &every_render } else { &all_reasons })?)
        } else {
            let if_any = |fact, name, why: &str| {
                reason_of(&choices.facts, fact).map(|reason| kernel(name, name, &choices, why, reason)).transpose()
            };
            // The scatter kernel of one material is the stage's file with a list of one material.
            let queued_scatter = |(queue, material): (u32, &Entry)| {
                let served = [Entry { closes: true, ..material.clone() }];
                let (own, _) = choose(&served, queue, false);
                let name = format!("scatter_{}", material.name);
                kernel(&name, "scatter", &own, &material.why.to_string(), &material.why)
            };
            Bounce::Staged(Box::new(Staged {
                intersect: always(
                    "intersect",
                    if reason_of(&choices.facts, "surface").is_none() { &every_render } else { &geometry },
                )?,
                medium: if_any("medium", "medium", &media)?,
                dispatch: if_any("queues", "dispatch", &format!("a queue for each material ({QUEUES})"))?,
                scatter: match queues {
                    true => (0..).zip(&materials).map(queued_scatter).collect::<Result<_>>()?,
                    false => if_any("surface", "scatter", &all_materials)?.into_iter().collect(),
                },
                shadow: if_any("light", "shadow", &emitters)?,
                refill: always("refill", &every_render)?,
            }))
        };
        let generate = always("generate", &every_render)?;
        let settings = SettingsLayout::from_module(&generate.module)?;
        let accumulate = always("accumulate", &every_render)?;
        let link_truth = |reason: &Reason| kernel("truth", "truth", &choices, &reason.to_string(), reason);
        let truth = reason_of(&choices.facts, "truth").map(link_truth).transpose()?;
        let link_light_path = |reason: &Reason| {
            let (own, _) = choose(&materials, 0, true);
            kernel("light_path", "light_path", &own, &reason.to_string(), reason)
        };
        let light_path = reason_of(&choices.facts, "light_paths").map(link_light_path).transpose()?;
        Ok(Kernels {
            generate,
            bounce,
            accumulate,
            truth,
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
    pub fn all(&self) -> Vec<&Arc<Kernel>> {
        let mut all = vec![&self.generate];
        match &self.bounce {
            Bounce::Fused(kernel) => all.push(kernel),
            Bounce::Staged(staged) => {
                let Staged { intersect, medium, dispatch, scatter, shadow, refill } = &**staged;
                all.extend(std::iter::once(intersect).chain(medium).chain(dispatch).chain(scatter).chain(shadow));
                all.push(refill);
            }
        }
        all.extend(&self.truth);
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
}

/// "sphere light (objects.ron:3:9), quad light (…)"
fn names_with_reasons(features: &Features, groups: &[&str]) -> String {
    let declared = groups.iter().filter_map(|group| Declared::of(group));
    let known = declared.flat_map(|declared| known_of(declared, features));
    let each = known.filter_map(|known| Some(format!("{} ({})", known.name, known.reason?)));
    each.collect::<Vec<_>>().join(", ")
}

/// The choices of a kernel for all materials of the scene, for benchmarks and tests that link their own.
pub fn choices_of(features: &Features, options: &RenderOptions, tables: &UniformTables) -> Choices {
    let materials = materials(features);
    let bounces = Bounces { fused: true, queues: false };
    decide(features, options, tables, &materials, 0, Purpose { served: &materials, bounces, light_path: false }).0
}

/// A kernel as its choices make it, or as they made it before if it is still kept.
fn kernel(name: &str, stage: &'static str, choices: &Choices, why: &str, reason: &Reason) -> Result<Arc<Kernel>> {
    /// The latest ones, in the order in which they were made.
    static KEPT: Mutex<Vec<Arc<Kernel>>> = Mutex::new(Vec::new());
    let lock = || KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    let is_same = |kept: &Arc<Kernel>| {
        (kept.stage, &*kept.name, &*kept.why) == (stage, name, why)
            && kept.reason == *reason
            && kept.choices == *choices
    };
    if let Some(kernel) = lock().iter().find(|kept| is_same(kept)) {
        return Ok(Arc::clone(kernel));
    }
    let linked = link(&Embedded, &format!("stage/{stage}"), choices)?;
    let (module, _) = linked.validate()?;
    let bindings = layout::bindings(&module)?;
    let (name, choices, why, reason) = (name.to_string(), choices.clone(), why.to_string(), reason.clone());
    let kernel = Arc::new(Kernel { name, stage, choices, linked, module, bindings, why, reason });
    let mut kept = lock();
    kept.push(Arc::clone(&kernel));
    let too_many = kept.len().saturating_sub(KEPT_KERNELS);
    kept.drain(..too_many);
    Ok(kernel)
}

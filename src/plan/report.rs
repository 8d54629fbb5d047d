//! A plan in words and numbers: kernels, modules and buffers, their sizes, and the object or option that needs each.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::facts::{Known, known_of};
use super::{Bounce, Kernel, PathField, Plan, QUEUES, STEPS, Tuning};
use crate::error::Result;
use crate::flatten::{DECLARED, Features, NotSampled};
use crate::gpu::buffers::BufferSpec;
use crate::gpu::layout::{self, BindingKind};
use crate::gpu::link::{Embedded, Library, Reason, When};
use crate::gpu::spirv::{self, KernelSize};
use crate::options::{Integrator, Scatter, default_of};

/// A plan in words and numbers.
#[derive(Clone, Debug)]
pub struct Report {
    /// The features of the scene that are linked, by name, each with the object that needs it.
    pub features: Vec<(String, String)>,
    /// Features that this scene does not need.
    pub left_out: Vec<String>,
    pub choices: Vec<Choice>,
    /// Whether rays are sent to lights, and why not.
    pub integrator: String,
    /// How the stages of a bounce are linked, and why.
    pub scatter: String,
    pub kernels: Vec<KernelReport>,
    pub slots: u32,
    pub path_fields: Vec<PathField>,
    pub constants: Vec<Constant>,
    pub buffers: Vec<Buffer>,
    /// The most bytes of a binding on the device, as uniform and as storage.
    pub limits: [u64; 2],
}

/// A choice between modules, the same in all kernels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Choice {
    pub name: String,
    pub module: String,
}

/// A kernel.
#[derive(Clone, Debug)]
pub struct KernelReport {
    pub name: String,
    pub why: String,
    /// Names of the scene's features that it has code for.
    pub features: Vec<String>,
    pub modules: Vec<Module>,
    /// By name, and how each is bound.
    pub bindings: Vec<(String, &'static str)>,
    /// The most storage buffers that the device allows a kernel.
    pub storage_limit: u64,
    pub path_fields: Vec<PathField>,
    pub wgsl_bytes: u64,
    /// As SPIR-V, if it was measured.
    pub size: Option<KernelSize>,
}

/// A module of a kernel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Module {
    pub name: String,
    /// The module that uses it; `None` for the kernel's root.
    pub used_by: Option<String>,
    /// The object of the scene or the option that needs it; `None` for modules of all renders.
    pub reason: Option<String>,
}

/// A number that is part of the kernels' code, known when they are compiled.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Constant {
    pub name: String,
    pub value: String,
    pub what: String,
    pub reason: String,
    /// Whether it is an override constant; otherwise it is filled into the text.
    pub is_override: bool,
    pub kernels: Vec<String>,
}

/// A buffer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Buffer {
    pub name: &'static str,
    pub what: &'static str,
    pub bytes: u64,
    /// How the number of bytes comes about.
    pub size: String,
    /// "uniform" or "storage".
    pub binding: &'static str,
    /// The most bytes that the device allows it.
    pub limit: u64,
    pub reason: String,
}

impl Buffer {
    pub fn fits(&self) -> bool {
        self.bytes <= self.limit
    }
}

impl Choice {
    /// The chosen module in a word: "yes" or "no" for a feature, or the default of an option.
    pub fn answer(&self) -> String {
        let name = self.module.rsplit('/').next().unwrap_or(&self.module);
        let own: Vec<&str> = self.name.split('_').collect();
        let rest: Vec<&str> = name.split('_').filter(|word| !own.contains(word)).collect();
        match rest.is_empty() {
            true => self.option_default().unwrap_or("yes").to_string(),
            false => rest.join(" "),
        }
    }

    /// The default of the option whose values its modules name.
    fn option_default(&self) -> Option<&'static str> {
        let heads = &Embedded.heads().choices().get(&self.name)?.heads;
        let facts = heads.iter().flat_map(|head| head.when.iter().flat_map(When::facts));
        facts.filter_map(|fact| default_of(fact.split_once('.')?.0)).next()
    }
}

impl KernelReport {
    /// How many of its bindings are storage buffers.
    pub fn storage_buffers(&self) -> u64 {
        self.bindings.iter().filter(|(_, kind)| *kind != "uniform").count() as u64
    }
}

impl Report {
    /// Without the kernels' sizes, which take time ([`Report::measure`]).
    pub fn new(plan: &Plan<'_>, limits: &wgpu::Limits) -> Report {
        let (features, tuning) = (&plan.kernels.features, &plan.tuning);
        let kernels = plan.kernels();
        let linked: BTreeSet<&String> = kernels.iter().flat_map(|kernel| &kernel.linked.modules).collect();
        let known: Vec<_> = DECLARED.iter().flat_map(|declared| known_of(declared, features)).collect();
        let (there, left_out): (Vec<_>, Vec<_>) = known.iter().partition(|known| linked.contains(&known.module));
        let with_reason = |known: &&Known<'_>| Some((known.name.clone(), known.reason?.to_string()));
        let heads = Embedded.heads().choices();
        let is_alternative = |(name, _): &(&String, _)| heads.get(*name).is_some_and(|own| own.is_alternative);
        let choices = kernels.iter().flat_map(|kernel| &kernel.linked.choices).filter(is_alternative);
        let choices: BTreeMap<_, _> = choices.collect();
        let of_kernel = |kernel: &&Arc<Kernel>| KernelReport {
            name: kernel.name.clone(),
            why: kernel.why.clone(),
            features: there
                .iter()
                .filter(|known| known.reason.is_some() && kernel.linked.modules.contains(&known.module))
                .map(|known| known.name.clone())
                .collect(),
            modules: modules(kernel),
            bindings: kernel.bindings.iter().map(|(name, binding)| (name.clone(), kind_word(binding.kind))).collect(),
            storage_limit: u64::from(limits.max_storage_buffers_per_shader_stage),
            path_fields: path_fields(kernel, plan),
            wgsl_bytes: kernel.linked.text.len() as u64,
            size: None,
        };
        let buffer = |spec: &BufferSpec<'_>| Buffer {
            name: spec.name,
            what: spec.why,
            bytes: spec.allocated(),
            size: spec.size.clone(),
            binding: spec.binding(),
            limit: spec.limit(limits),
            reason: why_buffer(&kernels, spec.name).to_string(),
        };
        Report {
            features: there.iter().filter_map(with_reason).collect(),
            left_out: left_out.iter().map(|known| known.name.clone()).collect(),
            choices: choices
                .into_iter()
                .map(|(name, module)| Choice { name: name.clone(), module: module.clone() })
                .collect(),
            integrator: integrator_words(features, plan.options.integrator),
            scatter: scatter_words(plan),
            kernels: kernels.iter().map(of_kernel).collect(),
            slots: tuning.slots,
            path_fields: plan.kernels.path_fields.clone(),
            constants: constants(&kernels, tuning),
            buffers: plan.buffers().iter().map(buffer).collect(),
            limits: [limits.max_uniform_buffer_binding_size, limits.max_storage_buffer_binding_size]
                .map(|limit| limit.min(limits.max_buffer_size)),
        }
    }

    /// Measures the sizes of the kernels.
    ///
    /// # Errors
    /// `Error::Shader` if a kernel cannot be written as SPIR-V: a defect of gpu-rt.
    pub fn measure(&mut self, plan: &Plan<'_>) -> Result<()> {
        for (report, kernel) in self.kernels.iter_mut().zip(plan.kernels()) {
            let workgroup = [("WORKGROUP_SIZE", f64::from(plan.tuning.workgroup))];
            report.size = Some(spirv::size(&kernel.module, kernel.stage, &workgroup)?);
        }
        Ok(())
    }

    /// Sets the steps that a device allows the walks, if they differ from the kernels' own.
    pub fn allow_steps(&mut self, most: Option<u32>) {
        let of_steps = |constant: &&mut Constant| STEPS.contains(&constant.name.as_str());
        if let Some(most) = most {
            self.constants.iter_mut().filter(of_steps).for_each(|constant| constant.value = most.to_string());
        }
    }

    pub fn path_bytes(&self) -> u64 {
        self.path_fields.iter().map(PathField::bytes).sum()
    }

    /// Bytes of all buffers.
    pub fn gpu_bytes(&self) -> u64 {
        self.buffers.iter().map(|buffer| buffer.bytes).sum()
    }

    /// The constants in the code of a kernel.
    pub fn constants_of(&self, kernel: &str) -> Vec<&Constant> {
        self.constants.iter().filter(|constant| constant.kernels.iter().any(|name| name == kernel)).collect()
    }
}

/// The modules of a kernel, each after the one that uses it.
fn modules(kernel: &Kernel) -> Vec<Module> {
    let linked = &kernel.linked;
    let mut users: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for name in linked.modules.iter().filter(|name| **name != linked.root) {
        let user = linked.used_by.get(name).unwrap_or(&linked.root);
        users.entry(user).or_default().push(name);
    }
    let mut ordered = Vec::with_capacity(linked.modules.len());
    let mut waiting = vec![(linked.root.as_str(), None)];
    while let Some((name, user)) = waiting.pop() {
        ordered.push(Module {
            name: name.to_string(),
            used_by: user.map(str::to_string),
            reason: Some(why_module(kernel, name)).filter(|why| **why != Reason::EveryRender).map(Reason::to_string),
        });
        let mut used = users.remove(name).unwrap_or_default();
        used.sort_unstable_by(|a, b| b.cmp(a));
        waiting.extend(used.into_iter().map(|used| (used, Some(name))));
    }
    ordered
}

/// The fields of the paths' state that a kernel loads or stores.
fn path_fields(kernel: &Kernel, plan: &Plan<'_>) -> Vec<PathField> {
    let constants = kernel.module.constants.iter().filter_map(|(_, constant)| constant.name.as_deref());
    let functions = kernel.module.functions.iter().filter_map(|(_, function)| function.name.as_deref());
    let names: BTreeSet<&str> = constants.chain(functions).collect();
    plan.kernels.path_fields.iter().filter(|field| field.is_used(|name| names.contains(name))).cloned().collect()
}

/// The reason for a module of a kernel: its own, or that of the kernel.
fn why_module<'a>(kernel: &'a Kernel, module: &str) -> &'a Reason {
    let own = kernel.linked.why.get(module).filter(|why| **why != Reason::EveryRender);
    own.unwrap_or(&kernel.reason)
}

/// The reason for a buffer: that of a kernel that has it in every render, or else of the first kernel that has it.
fn why_buffer<'a>(kernels: &[&'a Arc<Kernel>], name: &str) -> &'a Reason {
    // The modules of queues also read tables that exist without queues.
    let rank = |why: &&Reason| match why {
        Reason::EveryRender => 0,
        Reason::Requested(by) => 1 + u8::from(by == QUEUES),
    };
    let having = kernels.iter().filter(|kernel| kernel.bindings.contains_key(name));
    let reasons = having.map(|kernel| why_module(kernel, &format!("bind/{name}")));
    reasons.min_by_key(rank).unwrap_or(&Reason::EveryRender)
}

fn kind_word(kind: BindingKind) -> &'static str {
    match kind {
        BindingKind::Uniform => "uniform",
        BindingKind::Read => "storage, read",
        BindingKind::ReadWrite => "storage, read and written",
    }
}

/// The numbers that the plan filled into lines of some kernel, and the override constants that some kernel has.
fn constants(kernels: &[&Arc<Kernel>], tuning: &Tuning) -> Vec<Constant> {
    let mut found: Vec<Constant> = Vec::new();
    let mut add = |kernel: &Kernel, name: String, value: String, module: &str, is_override| match found
        .iter_mut()
        .find(|known| known.name == name && known.value == value)
    {
        Some(known) => known.kernels.push(kernel.name.clone()),
        None => {
            let (what, reason) = (about_constant(&name), why_module(kernel, module).to_string());
            found.push(Constant { name, value, what, reason, is_override, kernels: vec![kernel.name.clone()] });
        }
    };
    for kernel in kernels {
        let linked = &kernel.linked;
        for (name, default) in layout::overrides(&kernel.module) {
            let value = if name == "WORKGROUP_SIZE" { Some(u64::from(tuning.workgroup)) } else { default };
            let value = value.map_or_else(|| "?".to_string(), |value| value.to_string());
            let begins = format!("override {name}:");
            let line = linked.text.lines().zip(&linked.lines).find(|(line, _)| line.starts_with(&begins));
            let module = line.map_or(&linked.root, |(_, (module, _))| module);
            add(kernel, name, value, module, true);
        }
    }
    for kernel in kernels {
        for (name, (value, module)) in &kernel.linked.values {
            // The address spaces of tables are listed with the buffers, the steps of a walk as the value of an override, and the numbers of
            // materials are names.
            if !name.starts_with("space_of_") && !name.contains('.') && *name != "most_steps" && !value.is_empty() {
                add(kernel, name.to_string(), value.trim_start_matches([',', ' ']).to_string(), module, false);
            }
        }
    }
    found
}

/// The meaning of a constant.
fn about_constant(name: &str) -> String {
    if let Some(table) = name.strip_prefix("size_of_") {
        return format!("capacity of the binding `{table}`");
    }
    let what = match name {
        "WORKGROUP_SIZE" => "invocations per workgroup",
        "MOST_STEPS_OF_WALK" => "steps after which a walk is given up; 262144 where the driver's loops have no limit",
        "MOST_STEPS_OF_CROSSINGS" => "steps after which the walks of a ray through media are given up",
        "stack_size" => "most nodes that wait in a walk through the hierarchy",
        "boundary_stack_size" => "the same in a mesh that bounds a medium",
        "media" => "media that rays cross",
        "sky_light" => "the index of the sky among the lights",
        "sky_columns" => "columns of the table that directions to the sky are sampled from",
        "sky_rows" => "rows of that table",
        "run_length" => "most samples in a run",
        "iterations_of_shading" => "most loop iterations of a material's textures",
        "pane_steps" => "steps of a walk that passing a pane costs",
        "queues" => "queues that slots are sorted into",
        "queue" => "the queue that the kernel serves",
        "film_sums" => "sums per pixel in the film",
        "matte_kinds" => "kinds of mattes of a pixel",
        "path_sums" => "sums of --aov, one at least",
        _ => "",
    };
    what.to_string()
}

fn integrator_words(features: &Features, integrator: Integrator) -> String {
    let left = features.not_sampled.as_ref().map_or(String::new(), |left| {
        let NotSampled { lights, total, reason } = left;
        format!("{lights} of {total} lights are found by BSDF sampling alone, {reason}")
    });
    match features.quantities.lights {
        0 if integrator == Integrator::Bsdf => "bsdf: --integrator bsdf".to_string(),
        0 if left.is_empty() => "bsdf: there is no light to sample".to_string(),
        0 => format!("bsdf: {left}"),
        1 if left.is_empty() => "mis: a ray to the light at each event".to_string(),
        lights if left.is_empty() => format!("mis: a ray to one of {lights} lights at each event"),
        1 => format!("mis: a ray to one light at each event; {left}"),
        lights => format!("mis: a ray to one of {lights} lights at each event; {left}"),
    }
}

fn scatter_words(plan: &Plan<'_>) -> String {
    match (&plan.kernels.bounce, plan.tuning.scatter) {
        (Bounce::Fused(_), _) => {
            "fused: a processor pays more for storing a path's state than for its divergence (docs/dev/performance.md)"
                .to_string()
        }
        (Bounce::Staged(_), _) if plan.tuning.is_short => {
            "linked: a fused kernel takes longer to compile than so few paths to render (docs/dev/performance.md)"
                .to_string()
        }
        (Bounce::Staged(staged), _) if staged.scatter.is_empty() => "none: there is nothing to hit".to_string(),
        (Bounce::Staged(staged), _) if staged.dispatch.is_some() => {
            format!("queues: a kernel and a queue for each of {} materials", staged.scatter.len())
        }
        (Bounce::Staged(_), Scatter::Queues) => "linked: with one material there is nothing to sort".to_string(),
        (Bounce::Staged(_), _) => "linked: one kernel for all materials".to_string(),
    }
}

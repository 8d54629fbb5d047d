//! Test kernels: small WGSL modules under tests/shaders that import production modules by name and run them on rows of
//! input on the device. A module `test/x` is tests/shaders/x.wgsl; every other name is the production file. A wrong form
//! is planted as another text in place of a part of a production module.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::OnceLock;

use bytemuck::Pod;
use gpu_rt::data::Settings;
use gpu_rt::flatten::Features;
use gpu_rt::gpu::buffers::{BufferSpec, Buffers, Readback};
use gpu_rt::gpu::layout::{self, Binding};
use gpu_rt::gpu::link::{Choices, Embedded, Entry, Library, Reason, link};
use gpu_rt::gpu::pipeline::{Pipeline, PipelineSpec};
use gpu_rt::options::RenderOptions;
use gpu_rt::plan::{SettingsLayout, UniformTables, choices_of};

use super::device;
use super::files::{files, stem};

const WORKGROUP: u32 = 64;

/// A change: a production module, a part of its text, and what stands in for that part.
pub type Fault<'a> = (&'a str, &'a str, &'a str);

/// In place of a part: all of the text. What stands in is the name of another production module.
pub const MODULE: &str = "";

/// The production shaders, with the modules of tests/shaders beside them under `test/`.
pub struct Overlay {
    /// Modules of the tests, by name.
    tests: &'static BTreeMap<String, String>,
    /// Production modules with texts of their own.
    rewritten: BTreeMap<String, String>,
}

impl Overlay {
    /// Everything under tests/shaders, and production modules with these changes, one after the other.
    pub fn new(replaced: &[Fault<'_>]) -> Overlay {
        static TESTS: OnceLock<BTreeMap<String, String>> = OnceLock::new();
        let tests = TESTS.get_or_init(|| {
            let text = |path: &PathBuf| std::fs::read_to_string(path).expect("a test shader can be read");
            let shaders = files("tests/shaders", ".wgsl", false).into_iter();
            shaders.map(|path| (format!("test/{}", stem(&path)), text(&path))).collect()
        });
        let own = Overlay { tests, rewritten: BTreeMap::new() };
        let with = |text: &str, part: &str, other: &str| match part {
            MODULE => Embedded.module(other).expect("a module").to_string(),
            _ => text.replace(part, other),
        };
        replaced
            .iter()
            .fold(own, |own, (production, part, other)| own.rewritten(production, |text| with(text, part, other)))
    }

    /// Adds a change of a production module's text.
    pub fn rewritten(mut self, production: &str, change: impl Fn(&str) -> String) -> Overlay {
        let own = self.module(production).unwrap_or_else(|| panic!("there is no module {production} to rewrite"));
        let text = change(own);
        assert_ne!(text, own, "{production} is as before");
        self.rewritten.insert(production.to_string(), text);
        self
    }
}

impl Library for Overlay {
    fn module(&self, name: &str) -> Option<&str> {
        static PRODUCTION: Embedded = Embedded;
        let own = self.rewritten.get(name).or_else(|| self.tests.get(name));
        own.map(String::as_str).or_else(|| PRODUCTION.module(name))
    }
}

/// The facts of the settings' members, which are all there.
const SETTINGS: [&str; 7] =
    ["lens", "background.gradient", "background.image", "camera_axes", "clamp", "event", "brute_force"];

/// Adds what is not there.
fn complete<K: Ord, V>(own: &mut BTreeMap<K, V>, usual: BTreeMap<K, V>) {
    for (name, value) in usual {
        own.entry(name).or_insert(value);
    }
}

/// A planted error: a production module, an expression in it, and the wrong one. `{{` and `}}` part the expression from the text around it, where it
/// stands more than once. Kernels have both expressions, and a number chooses, so that all errors of a kernel are compiled once.
pub type Plant = (&'static str, &'static str, &'static str);

/// The choices of a plan for a scene.
pub fn plan_of(features: &Features) -> Choices {
    choices_of(features, &RenderOptions::default(), &UniformTables::default())
}

/// An expression of `given`, a row of input, which tests/shaders/expression.wgsl evaluates: a module that it uses, the types of the row and of
/// what it gives, and the expression.
pub type Expression<'a> = [&'a str; 4];

pub fn values_of(of: Expression<'_>) -> [(&'static str, &str); 4] {
    [("module", of[0]), ("given", of[1]), ("gives", of[2]), ("expression", of[3])]
}

/// A test kernel, linked and validated.
#[derive(Clone)]
pub struct Kernel {
    name: String,
    module: naga::Module,
    text: String,
    bindings: BTreeMap<String, Binding>,
    /// The number of the planted error that is there, from 1 on; 0 for none.
    planted: u32,
}

/// What a test kernel is linked with beside its own file.
#[derive(Default)]
pub struct Setup<'a> {
    /// Changes of production modules, as `Overlay::new` takes them.
    pub replaced: &'a [Fault<'a>],
    /// Errors of which `Kernel::planted` chooses one.
    pub plants: &'a [Plant],
    /// The values behind `${name}`.
    pub values: &'a [(&'static str, &'a str)],
    /// Facts that hold, and facts that do not.
    pub facts: &'a [(&'a str, bool)],
    /// The choices of a plan, for kernels whose modules need more of them than those.
    pub plan: Choices,
}

impl Kernel {
    /// Links `test/NAME` as it is.
    pub fn new(name: &'static str) -> Kernel {
        Kernel::with(name, &Setup::default())
    }

    /// The same with production modules changed.
    pub fn replacing(name: &'static str, replaced: &[Fault<'_>]) -> Kernel {
        Kernel::with(name, &Setup { replaced, ..Setup::default() })
    }

    /// The kernel of an expression, with production modules changed.
    pub fn of(expression: Expression<'_>, replaced: &[Fault<'_>]) -> Kernel {
        Kernel::with("test/expression", &Setup { replaced, values: &values_of(expression), ..Setup::default() })
    }

    /// Links `test/NAME`, whose `run(row)` is called once for every row of input.
    pub fn with(name: &'static str, setup: &Setup<'_>) -> Kernel {
        let mut choices = setup.plan.clone();
        // By default, the choices of a plan for an empty scene.
        let nothing = plan_of(&Features::default());
        for fact in SETTINGS {
            choices.facts.entry(fact.to_string()).or_insert(Some(Reason::EveryRender));
        }
        complete(&mut choices.facts, nothing.facts);
        for list in ["layer", "inner_layer"] {
            choices.lists.entry(list).or_insert(nothing.lists[list].clone());
        }
        complete(&mut choices.values, nothing.values);
        complete(&mut choices.generated, nothing.generated);
        // Images of floats.
        let float = Entry { name: "float".to_string(), number: 0, closes: true, why: Reason::EveryRender };
        choices.lists.entry("texel_format").or_insert(vec![float]);
        let holds = |is_so: bool| is_so.then_some(Reason::EveryRender);
        choices.facts.extend(setup.facts.iter().map(|(fact, is_so)| ((*fact).to_string(), holds(*is_so))));
        choices.values.insert("kernel".to_string(), name.to_string());
        choices.values.extend(setup.values.iter().map(|(name, value)| (name.to_string(), value.to_string())));
        let mut overlay = Overlay::new(setup.replaced);
        let modules: BTreeSet<&str> = setup.plants.iter().map(|(module, ..)| *module).collect();
        for module in modules {
            let own = |text: &str| {
                let plants = (1..).zip(setup.plants).filter(|(_, plant)| plant.0 == module);
                plants.fold(text.to_string(), |text, (number, (_, part, other))| {
                    let (before, rest) = part.split_once("{{").unwrap_or(("", part));
                    let (right, after) = rest.split_once("}}").unwrap_or((rest, ""));
                    let found = [before, right, after].concat();
                    assert!(text.contains(&found), "{module} has no {found}");
                    let chosen = format!("{before}select(({right}), ({other}), job.planted == {number}u){after}");
                    text.replace(&found, &chosen)
                })
            };
            overlay = overlay.rewritten(module, own);
        }
        let linked = link(&overlay, "test/main", &choices).unwrap_or_else(|error| panic!("{name}: {error}"));
        let (module, _) = linked.validate().unwrap_or_else(|error| panic!("{name}: {error}"));
        let bindings = layout::bindings(&module).unwrap_or_else(|error| panic!("{name}: {error}"));
        Kernel { name: name.to_string(), module, text: linked.text, bindings, planted: 0 }
    }

    /// The same with the error of this index in `Setup::plants`.
    pub fn planted(&self, index: usize) -> Kernel {
        Kernel { planted: index as u32 + 1, ..self.clone() }
    }

    /// The settings as this kernel has them.
    pub fn settings(&self, settings: &Settings) -> BufferSpec<'static> {
        let contents = SettingsLayout::from_module(&self.module).expect("the settings have a layout").bytes(settings);
        let spec = BufferSpec::uniform("settings", contents.len() as u64, "the test");
        BufferSpec { contents: vec![contents.into()], ..spec }
    }

    /// Runs the kernel once for each row; one row of output for each of input.
    pub fn run<I: Pod, O: Pod>(&self, rows: &[I]) -> Vec<O> {
        self.run_with(rows, rows.len(), &[])
    }

    /// Runs the kernel `count` times over the input, as often for each of its rows, with further buffers by the names of their variables.
    pub fn run_with<I: Pod, O: Pod>(&self, input: &[I], count: usize, more: &[BufferSpec<'_>]) -> Vec<O> {
        self.run_again(input, count, more, 1)
    }

    /// Runs the kernel so many times one after the other, with the output of one before the next.
    pub fn run_again<I: Pod, O: Pod>(
        &self,
        input: &[I],
        count: usize,
        more: &[BufferSpec<'_>],
        dispatches: usize,
    ) -> Vec<O> {
        for (variable, bytes) in [("input", size_of::<I>()), ("output", size_of::<O>())] {
            let row = self.bindings[variable].element_bytes as usize;
            assert_eq!(row, bytes, "{}: a row of `{variable}` here and in its WGSL differ in bytes", self.name);
        }
        self.dispatch::<I, O>(input, count, more, dispatches, ("output", count))
    }

    /// Runs the kernel `count` times over the input; what comes back is so many rows of the buffer of this name.
    pub fn run_for<I: Pod, O: Pod>(
        &self,
        input: &[I],
        count: usize,
        more: &[BufferSpec<'_>],
        wanted: (&str, usize),
    ) -> Vec<O> {
        self.dispatch(input, count, more, 1, wanted)
    }

    fn dispatch<I: Pod, O: Pod>(
        &self,
        input: &[I],
        count: usize,
        more: &[BufferSpec<'_>],
        dispatches: usize,
        (wanted, wanted_rows): (&str, usize),
    ) -> Vec<O> {
        let rows = u32::try_from(count).expect("a dispatch of less than 2^32 rows");
        let bytes = (wanted_rows * size_of::<O>()) as u64;
        let times = (count / input.len().max(1)).max(1) as u32;
        let mut job = BufferSpec::uniform("job", 12, "the test");
        job.contents = vec![bytemuck::cast_slice(&[rows, times, self.planted]).to_vec().into()];
        let input = BufferSpec::scene("input", vec![bytemuck::cast_slice(input).into()], "the test");
        let output_bytes = count as u64 * u64::from(self.bindings["output"].element_bytes);
        let output = BufferSpec::working("output", output_bytes, "the test");
        let mut specs = vec![job, input, output];
        specs.extend_from_slice(more);
        // Of those who do not say, some only ask for its zero.
        if self.bindings.contains_key("settings") && !more.iter().any(|spec| spec.name == "settings") {
            specs.push(self.settings(&Settings::default()));
        }

        let device = device::software();
        let buffers = Buffers::create(device, &specs).expect("the test's buffers fit");
        let spec = PipelineSpec {
            name: &self.name,
            entry_point: "main",
            module: &self.module,
            text: &self.text,
            bindings: &self.bindings,
            workgroup: WORKGROUP,
            constants: &[],
        };
        let pipeline = Pipeline::new(device, &spec, &buffers).expect("the test kernel compiles");
        let readback = Readback::new(device, wanted, bytes);
        let mut encoder = device.encoder("test");
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            for _ in 0..dispatches {
                pipeline.dispatch(&mut pass, rows.div_ceil(WORKGROUP));
            }
        }
        let copied = readback.copy(device, &mut encoder, buffers.get(wanted).expect("it was made above"), 0, bytes);
        copied.expect("the device works");
        let submission = device.submit(encoder);
        readback.read(device, submission, bytes, bytemuck::pod_collect_to_vec::<u8, O>).expect("the test kernel runs")
    }
}

/// An array, as a buffer that kernels read.
pub fn array<'a, T: Pod>(name: &'static str, items: &'a [T]) -> BufferSpec<'a> {
    BufferSpec::scene(name, vec![bytemuck::cast_slice(items).into()], "the test")
}

//! Compiles every kernel of the scenes that ship for real GPUs, on a machine without one, and compares the figures with those of
//! docs/dev/gpu-kernels.tsv. `make gpu-compile` runs it; with GPU_RT_RENEW=1 it writes them anew. With `--variant` and a name it prints
//! what kernels of that variant take over the usual ones. `--isa FOLDER` and a variant write the code of the walks there (benches/dependent_loads.py).
//!
//! Mesa's RADV opens on no hardware at all where RADV_FORCE_FAMILY names a GPU. It compiles pipelines for it and says what they take,
//! but runs nothing. wgpu waits for its queue in vain, so this program calls Vulkan itself.

use std::collections::BTreeMap;
use std::error::Error;
use std::ffi::CString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use ash::vk;
use gpu_rt::flatten::flatten;
use gpu_rt::gpu::device::DeviceClass;
use gpu_rt::gpu::layout::{self, BindingKind};
use gpu_rt::gpu::numerics::MOST_STEPS;
use gpu_rt::gpu::spirv;
use gpu_rt::options::{RenderOptions, Scatter, Walk};
use gpu_rt::plan::{Kernels, STEPS, UniformTables};
use gpu_rt::scene::Scene;
use naga::back::spv;
use naga::proc::{BoundsCheckPolicies, BoundsCheckPolicy};
use serde_json::{Value, json};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// A GPU that kernels are compiled for.
struct Family {
    /// RADV's name for it.
    name: &'static str,
    what: &'static str,
    /// Whether the file has the figures of every kernel, or only of those that spill.
    every_kernel: bool,
}

const FAMILIES: [Family; 3] = [
    Family { name: "navi31", what: "RDNA 3, the Radeon RX 7900", every_kernel: true },
    Family { name: "navi21", what: "RDNA 2, the Radeon RX 6800 and 6900", every_kernel: false },
    Family { name: "gfx1201", what: "RDNA 4, the Radeon RX 9070", every_kernel: false },
];
const WAYS: [(&str, Scatter); 3] =
    [("fused", Scatter::Fused), ("linked", Scatter::Linked), ("queues", Scatter::Queues)];
/// All figures: a line for each kernel, with tabs between the columns.
const FILE: &str = "docs/dev/gpu-kernels.tsv";
const DOCUMENT: &str = "docs/dev/gpu-kernels.md";
/// What stands below this line of the document is written by this program.
const BEGIN: &str = "## Figures\n";
/// A figure that grows by more than this factor is a fault.
const GROWTH: f64 = 1.05;
/// The options of the process that compiles: with the second one it writes the kernels' code beside them, which takes longer.
const COMPILE: &str = "--compile";
const SHOW: &str = "--compile-and-show";
/// Invocations of a workgroup, as by default.
const WORKGROUP: f64 = 64.0;

/// The figures of a kernel: RADV's names of them, and their heads in the tables.
const FIGURES: [(&str, &str); 9] = [
    ("VGPRs", "VGPRs"),
    ("SGPRs", "SGPRs"),
    ("Spilled VGPRs", "spilled VGPRs"),
    ("Spilled SGPRs", "spilled SGPRs"),
    ("Scratch size", "scratch bytes"),
    ("Subgroups per SIMD", "subgroups a SIMD"),
    ("Instructions", "instructions"),
    ("Code size", "code bytes"),
    ("Inverse Throughput", "inverse throughput"),
];
/// Those that must not grow by more than [`GROWTH`].
const WATCHED: [&str; 2] = ["VGPRs", "instructions"];
/// Those that must not grow at all.
const SPILLS: [&str; 3] = ["spilled VGPRs", "spilled SGPRs", "scratch bytes"];

/// A kernel's figures, in the order of [`FIGURES`].
#[derive(Clone, Debug, PartialEq, Eq)]
struct Figures([u64; FIGURES.len()]);

impl Figures {
    fn get(&self, head: &str) -> u64 {
        let index = FIGURES.iter().position(|(_, known)| *known == head);
        index.and_then(|index| self.0.get(index)).copied().unwrap_or(0)
    }

    fn spills(&self) -> bool {
        SPILLS.iter().any(|head| self.get(head) > 0)
    }
}

/// Where a kernel comes from: the scene, the way of linking, and the kernel's name.
type Key = (String, String, String);
/// The figures of one GPU's kernels.
type Table = BTreeMap<Key, Figures>;
/// A row of the file: scene, ways of linking, kernel, figures.
type Row = (String, String, String, Figures);

/// A kernel as it is handed to the driver.
struct Compiled {
    key: Key,
    entry_point: String,
    words: Vec<u32>,
    /// Numbers of the bindings, whether they are uniforms, and their names.
    bindings: Vec<(u32, bool, String)>,
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    match &words[..] {
        [] => check(),
        [option, name] if option == "--variant" => compare(variant(name)?, name),
        [option, folder, name] if option == "--isa" => walks(variant(name)?, Path::new(folder)),
        [option, folder] if [COMPILE, SHOW].contains(&option.as_str()) => {
            println!("{}", compile_all(Path::new(folder), option == SHOW)?);
            Ok(())
        }
        _ => Err("expected no arguments".into()),
    }
}

/// What differs from the kernels as they are.
#[derive(Clone, Copy, PartialEq)]
enum Variant {
    Usual,
    /// Without checks of indices and bounds of loops.
    Unchecked,
    /// Without products that are fused with sums.
    Uncontracted,
    /// With the children of nodes of meshes beside each other.
    Siblings,
}

fn variant(name: &str) -> Result<Variant> {
    match name {
        "usual" => Ok(Variant::Usual),
        "unchecked" => Ok(Variant::Unchecked),
        "uncontracted" => Ok(Variant::Uncontracted),
        "siblings" => Ok(Variant::Siblings),
        _ => Err(format!("no variant is named {name}").into()),
    }
}

/// Compiles the kernels of `--scatter linked` that walk to the next surface, for each GPU, and writes their code into a folder.
fn walks(variant: Variant, into: &Path) -> Result<()> {
    let folder = tempfile::tempdir()?;
    fs::create_dir_all(into)?;
    let is_walk = |(_, way, name): &Key| way == "linked" && name == "intersect";
    // The first is left out below, as the planted one is elsewhere.
    let mut kernels: Vec<_> =
        kernels(variant)?.into_iter().filter(|one| is_walk(&one.key) || one.key == planted_key()).collect();
    kernels.push(chase(variant)?);
    let numbers = written(&kernels, folder.path())?;
    for family in &FAMILIES {
        let (_, figures) = compiled_for(family.name, folder.path(), SHOW)?;
        for (kernel, number) in kernels.iter().zip(&numbers).skip(1) {
            let name = format!("{}-{}", family.name, kernel.key.0);
            let of = |head: &str| figures.get(*number).map_or(0, |own| own.get(head));
            let [vgprs, subgroups, instructions] = ["VGPRs", "subgroups a SIMD", "instructions"].map(of);
            println!("{name}: {vgprs} VGPRs, {subgroups} subgroups a SIMD, {instructions} instructions");
            let bindings: Vec<&str> = kernel.bindings.iter().map(|(.., name)| name.as_str()).collect();
            let code = fs::read_to_string(folder.path().join(format!("{number}.s")))?;
            // This Mesa has no names for the newest instructions.
            if code.starts_with("BB0:") {
                let code = code.trim_end_matches('\0');
                fs::write(into.join(name + ".s"), format!("; {}\n{code}", bindings.join(" ")))?;
            }
        }
    }
    Ok(())
}

/// Prints the figures of a variant over the usual ones: geometric means over the kernels, and the extremes.
fn compare(variant: Variant, name: &str) -> Result<()> {
    for family in &FAMILIES {
        let of = |variant| -> Result<Vec<Figures>> {
            let folder = tempfile::tempdir()?;
            let kernels = kernels(variant)?;
            let numbers = written(&kernels, folder.path())?;
            let (_, figures) = compiled_for(family.name, folder.path(), COMPILE)?;
            Ok(numbers.into_iter().skip(1).filter_map(|number| figures.get(number).cloned()).collect())
        };
        let (usual, other) = (of(Variant::Usual)?, of(variant)?);
        for head in ["VGPRs", "subgroups a SIMD", "instructions", "inverse throughput"] {
            let ratio = |(a, b): (&Figures, &Figures)| b.get(head) as f64 / (a.get(head) as f64).max(1.0);
            let ratios: Vec<f64> = usual.iter().zip(&other).map(ratio).collect();
            let mean = (ratios.iter().map(|ratio| ratio.ln()).sum::<f64>() / ratios.len() as f64).exp();
            let (least, most) = ratios.iter().fold((f64::MAX, 0f64), |(least, most), r| (least.min(*r), most.max(*r)));
            println!(
                "{}, {name}: {mean:.3} of the {head} ({least:.2} to {most:.2}), {} kernels",
                family.name,
                ratios.len()
            );
        }
    }
    Ok(())
}

/// Writes the kernels into a folder, those that are the same once. The result has the number of each.
fn written(kernels: &[Compiled], folder: &Path) -> Result<Vec<usize>> {
    let mut numbers = Vec::new();
    let mut index = Vec::new();
    let mut known: BTreeMap<&[u32], usize> = BTreeMap::new();
    for kernel in kernels {
        let number = *known.entry(&kernel.words).or_insert(index.len());
        if number == index.len() {
            let path = folder.join(format!("{number}.spv"));
            fs::write(&path, kernel.words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<u8>>())?;
            validate(&path, &kernel.key)?;
            index.push(json!({"file": path, "entry_point": kernel.entry_point, "bindings": kernel.bindings}));
        }
        numbers.push(number);
    }
    let (all, different) = (kernels.len() - 1, index.len() - 1);
    fs::write(folder.join("index.json"), Value::from(index).to_string())?;
    eprintln!("{all} kernels, {different} of them different; spirv-val finds no fault in them");
    Ok(numbers)
}

/// Compiles all kernels for every GPU, and compares or writes the tables.
fn check() -> Result<()> {
    let folder = tempfile::tempdir()?;
    let kernels = kernels(Variant::Usual)?;
    let numbers = written(&kernels, folder.path())?;
    let all = kernels.len() - 1;

    let document = root().join(DOCUMENT);
    let text = fs::read_to_string(&document)?;
    let (prose, committed) = text.split_once(BEGIN).ok_or(format!("{DOCUMENT} has no line `{}`", BEGIN.trim()))?;
    let rows_there = fs::read_to_string(root().join(FILE))?;
    let renew = std::env::var_os("GPU_RT_RENEW").is_some();
    let (mut faults, mut written) = (Vec::new(), String::new());
    let mut lines = format!("GPU\tscene\t--scatter\tkernel\t{}\n", FIGURES.map(|(_, head)| head).join("\t"));
    for family in &FAMILIES {
        let name = family.name;
        let (driver, figures) = compiled_for(name, folder.path(), COMPILE)?;
        let mut table = Table::new();
        for (kernel, number) in kernels.iter().zip(&numbers) {
            let own = figures.get(*number).ok_or("the driver left out a kernel")?;
            table.insert(kernel.key.clone(), own.clone());
        }
        let planted = table.remove(&planted_key()).ok_or("the planted kernel is missing")?;
        controls(&planted, &table)?;
        let head = format!("{name}: {}, by {driver}", family.what);
        let old = figures_of(&rows_there, name);
        let old_head = committed.lines().find(|line| line.starts_with(&format!("- {name}: "))).unwrap_or_default();
        let compares = Compares { figures: old_head.starts_with(&format!("- {head}.")), rows: family.every_kernel };
        if !compares.figures && !renew {
            eprintln!("{head}: {DOCUMENT} has `{old_head}`, so only new spills are looked for");
        }
        faults.extend(worse(&table, &old, compares).into_iter().map(|fault| format!("{name}: {fault}")));
        let spilling = table.values().filter(|figures| figures.spills()).count();
        eprintln!("{head}: {spilling} of {all} kernels spill or use scratch");
        written += &in_words(&head, &table);
        lines += &in_lines(name, &table, family.every_kernel);
    }
    faults.iter().for_each(|fault| eprintln!("{fault}"));
    if renew {
        fs::write(&document, format!("{prose}{BEGIN}\n{written}"))?;
        fs::write(root().join(FILE), lines)?;
        eprintln!("{FILE} has these figures now");
    } else if !faults.is_empty() {
        return Err(format!("{} kernels differ from {FILE}; GPU_RT_RENEW=1 writes it anew", faults.len()).into());
    }
    Ok(())
}

/// Every kernel of the scenes that ship, in every way of linking, as for a GPU; and the planted one.
fn kernels(variant: Variant) -> Result<Vec<Compiled>> {
    let mut names = Vec::new();
    for entry in fs::read_dir(root().join("scenes"))? {
        let path = entry?.path();
        if path.extension().is_some_and(|extension| extension == "ron") {
            names.extend(path.file_stem().map(|stem| stem.to_string_lossy().into_owned()));
        }
    }
    names.sort();
    let walk = if variant == Variant::Siblings { Walk::Siblings } else { Walk::Coded };
    let options = RenderOptions { walk, ..RenderOptions::default() };
    let mut all = vec![planted(variant)?];
    for name in names {
        let scene = Scene::load(&root().join(format!("scenes/{name}.ron")))?;
        let flat = flatten(&scene, (scene.image.width, scene.image.height), &options)?;
        let options = RenderOptions { light_paths: flat.light_paths(&options), ..options.clone() };
        // Tables are storage, as on every GPU.
        let tables = UniformTables::new(&flat, DeviceClass::default());
        for (way, scatter) in WAYS {
            for kernel in Kernels::link(&flat.features.with_options(&options), &options, scatter, &tables)?.all() {
                let key = (name.clone(), way.to_string(), kernel.name.clone());
                all.push(compiled(key, kernel.stage, &kernel.module, variant)?);
            }
        }
    }
    Ok(all)
}

/// The SPIR-V of a kernel as wgpu 30 hands it to RADV, with robust buffers (VK_EXT_robustness2) and Vulkan 1.3.
fn compiled(key: Key, entry_point: &str, module: &naga::Module, variant: Variant) -> Result<Compiled> {
    let mut overrides = vec![("WORKGROUP_SIZE", WORKGROUP)];
    overrides.extend(STEPS.map(|name| (name, f64::from(MOST_STEPS))));
    let (resolved, info) = spirv::resolved(module, entry_point, &overrides)?;
    let is_checked = variant != Variant::Unchecked;
    let options = spv::Options {
        lang_version: (1, 6),
        flags: spv::WriterFlags::LABEL_VARYINGS | spv::WriterFlags::FORCE_POINT_SIZE,
        bounds_check_policies: BoundsCheckPolicies {
            index: if is_checked { BoundsCheckPolicy::Restrict } else { BoundsCheckPolicy::Unchecked },
            // The driver checks buffers itself.
            ..BoundsCheckPolicies::default()
        },
        force_loop_bounding: is_checked,
        emit_int_div_checks: is_checked,
        zero_initialize_workgroup_memory: spv::ZeroInitializeWorkgroupMemoryMode::Native,
        ..spv::Options::default()
    };
    let stage = naga::ShaderStage::Compute;
    let pipeline = spv::PipelineOptions { shader_stage: stage, entry_point: entry_point.to_string() };
    let mut words = spv::write_vec(&resolved, &info, &options, Some(&pipeline))?;
    if variant == Variant::Uncontracted {
        words = spirv::with_no_contraction(&words);
    }
    let bindings = layout::bindings(module)?;
    let known =
        |(name, binding): (String, layout::Binding)| (binding.number, binding.kind == BindingKind::Uniform, name);
    let mut bindings: Vec<_> = bindings.into_iter().map(known).collect();
    bindings.sort_unstable();
    Ok(Compiled { key, entry_point: entry_point.to_string(), words, bindings })
}

fn planted_key() -> Key {
    let none = String::new();
    (none.clone(), none, "planted".to_string())
}

/// A kernel that must use scratch: its array is too large for registers, and its indices are known only at run time.
fn planted(variant: Variant) -> Result<Compiled> {
    let text = "@group(0) @binding(0) var<storage, read_write> words: array<u32>;\n\
                @compute @workgroup_size(64) fn planted(@builtin(global_invocation_id) id: vec3u) {\n\
                    var kept: array<u32, 1024>;\n\
                    for (var i = 0u; i < 1024u; i++) { kept[words[i] & 1023u] = words[i + id.x]; }\n\
                    words[id.x] = kept[words[id.x] & 1023u];\n\
                }\n";
    compiled(planted_key(), "planted", &naga::front::wgsl::parse_str(text)?, variant)
}

/// A kernel with three loads in a row, for the control of benches/dependent_loads.py.
fn chase(variant: Variant) -> Result<Compiled> {
    let text = "@group(0) @binding(0) var<storage, read_write> words: array<u32>;\n\
                @compute @workgroup_size(64) fn chase(@builtin(global_invocation_id) id: vec3u) {\n\
                    var at = id.x;\n\
                    loop { at = words[words[words[at]]]; if at == 0u { break; } }\n\
                    words[id.x] = at;\n\
                }\n";
    let key = ["planted", "linked", "intersect"].map(str::to_string);
    compiled(key.into(), "chase", &naga::front::wgsl::parse_str(text)?, variant)
}

/// The comparison finds the planted spill, and a growth of each figure that is watched.
fn controls(planted: &Figures, table: &Table) -> Result<()> {
    let kernel = |figures: &Figures| Table::from([(planted_key(), figures.clone())]);
    let all = Compares { figures: true, rows: true };
    let spill = worse(&kernel(planted), &Table::new(), Compares { figures: false, rows: false });
    if spill.len() != 1 || !spill[0].contains("scratch") {
        return Err(format!("the planted spill was not found: {planted:?}").into());
    }
    let most = table.values().max_by_key(|figures| figures.get("instructions")).ok_or("there are no kernels")?;
    if !worse(&kernel(most), &kernel(most), all).is_empty() {
        return Err("a kernel is found to be worse than itself".into());
    }
    for head in WATCHED.iter().chain(&SPILLS) {
        let mut grown = most.clone();
        for (figure, (_, known)) in grown.0.iter_mut().zip(FIGURES) {
            *figure += if known == *head { *figure * 6 / 100 + 1 } else { 0 };
        }
        if worse(&kernel(&grown), &kernel(most), all).len() != 1 {
            return Err(format!("a growth of {head} by 6 % was not found").into());
        }
    }
    Ok(())
}

/// The parts of a table that are compared with the committed one.
#[derive(Clone, Copy)]
struct Compares {
    /// The figures themselves, where both are of the same driver. A new spill is found without them.
    figures: bool,
    /// Whether each kernel has a row.
    rows: bool,
}

/// A sentence for each kernel that is worse than it was.
fn worse(table: &Table, committed: &Table, compares: Compares) -> Vec<String> {
    let mut faults = Vec::new();
    for (key, figures) in table {
        let old = committed.get(key);
        let grown = |head: &str, factor: f64| {
            let (now, before) = (figures.get(head), old.map_or(0, |old| old.get(head)));
            (now as f64 > before as f64 * factor).then(|| format!("{now} {head} instead of {before}"))
        };
        // Another driver may spill more of what is known to spill.
        let known = !compares.figures && old.is_some_and(Figures::spills);
        let spills = SPILLS.iter().filter(|_| !known).filter_map(|head| grown(head, 1.0));
        let watched = WATCHED.iter().filter(|_| compares.figures && old.is_some());
        let mut what: Vec<_> = spills.chain(watched.filter_map(|head| grown(head, GROWTH))).collect();
        if compares.rows && old.is_none() {
            what.push("no row in the table".to_string());
        }
        if !what.is_empty() {
            faults.push(format!("{}: {}", in_short(key), what.join(", ")));
        }
    }
    let gone = committed.keys().filter(|key| !table.contains_key(*key));
    faults.extend(gone.map(|key| format!("{}: a row of the table, but no kernel", in_short(key))));
    faults
}

fn in_short((scene, way, kernel): &Key) -> String {
    format!("{scene}, --scatter {way}, {kernel}")
}

/// A GPU's line of the document: the driver, and whether kernels spill.
fn in_words(head: &str, table: &Table) -> String {
    let spilling = rows(table).into_iter().filter(|row| row.3.spills());
    let names: Vec<_> = spilling.map(|(scene, ways, kernel, _)| format!("{scene} {kernel} ({ways})")).collect();
    match names.is_empty() {
        true => format!("- {head}. None of the {} kernels spills or uses scratch.\n", table.len()),
        false => format!("- {head}. Kernels that spill or use scratch: {}.\n", names.join("; ")),
    }
}

/// A GPU's lines of the file: all kernels, or those that spill.
fn in_lines(family: &str, table: &Table, every_kernel: bool) -> String {
    let shown = rows(table).into_iter().filter(|row| every_kernel || row.3.spills());
    let lines = shown.map(|(scene, ways, kernel, figures)| {
        let figures = figures.0.map(|figure| figure.to_string()).join("\t");
        format!("{family}\t{scene}\t{ways}\t{kernel}\t{figures}\n")
    });
    lines.collect()
}

/// The table with one row for the ways of linking in which a kernel has the same figures.
fn rows(table: &Table) -> Vec<Row> {
    let mut rows: Vec<Row> = Vec::new();
    for ((scene, way, kernel), figures) in table {
        let same = rows.iter_mut().find(|row| row.0 == *scene && row.2 == *kernel && row.3 == *figures);
        match same {
            Some(row) => row.1 += &format!(", {way}"),
            None => rows.push((scene.clone(), way.clone(), kernel.clone(), figures.clone())),
        }
    }
    rows
}

/// The figures of a GPU's kernels in the file.
fn figures_of(file: &str, family: &str) -> Table {
    let mut table = Table::new();
    for line in file.lines() {
        let cells: Vec<&str> = line.split('\t').collect();
        let [gpu, scene, ways, kernel, figures @ ..] = &cells[..] else { continue };
        let numbers: Vec<u64> = figures.iter().filter_map(|cell| cell.parse().ok()).collect();
        let Ok(figures) = numbers.try_into() else { continue };
        let figures = Figures(figures);
        for way in ways.split(", ").filter(|_| *gpu == family) {
            table.insert((scene.to_string(), way.to_string(), kernel.to_string()), figures.clone());
        }
    }
    table
}

/// Khronos' validator on a kernel, as strict as for Vulkan 1.3.
fn validate(path: &Path, key: &Key) -> Result<()> {
    let validator = Command::new("spirv-val").args(["--target-env", "vulkan1.3"]).arg(path).output();
    let output = validator.map_err(|error| format!("spirv-val does not run (Debian package spirv-tools): {error}"))?;
    match output.status.success() {
        true => Ok(()),
        false => Err(format!("{}: {}", in_short(key), String::from_utf8_lossy(&output.stderr)).into()),
    }
}

/// Compiles the kernels of a folder for a GPU, in a process of its own: RADV reads the GPU's name from the environment.
fn compiled_for(family: &str, folder: &Path, option: &str) -> Result<(String, Vec<Figures>)> {
    let manifest = manifest()?;
    let output = Command::new(std::env::current_exe()?)
        .arg(option)
        .arg(folder)
        .env("RADV_FORCE_FAMILY", family)
        .env("VK_DRIVER_FILES", &manifest)
        .env("VK_ICD_FILENAMES", &manifest)
        .env("NODEVICE_SELECT", "1")
        // What is measured is compiled, not remembered.
        .env("MESA_SHADER_CACHE_DISABLE", "true")
        .output()?;
    if !output.status.success() {
        let why = String::from_utf8_lossy(&output.stderr);
        return Err(format!("{family}: {}: {why}A Mesa older than 25.0 may not know this GPU", output.status).into());
    }
    let report: Value = serde_json::from_slice(&output.stdout)?;
    let figures = |kernel: &Value| -> Result<Figures> {
        let mut figures = [0; FIGURES.len()];
        for (figure, (name, _)) in figures.iter_mut().zip(FIGURES) {
            *figure = kernel[name].as_u64().ok_or(format!("this driver reports no `{name}`: {kernel}"))?;
        }
        Ok(Figures(figures))
    };
    let kernels = report["kernels"].as_array().into_iter().flatten().map(figures).collect::<Result<_>>()?;
    Ok((report["driver"].as_str().unwrap_or_default().to_string(), kernels))
}

/// The file by which the Vulkan loader finds RADV: VK_DRIVER_FILES if that is set, else in the loader's own folders.
fn manifest() -> Result<PathBuf> {
    if let Some(given) = std::env::var_os("VK_DRIVER_FILES") {
        return Ok(given.into());
    }
    let data = std::env::var("XDG_DATA_DIRS").unwrap_or_default();
    let folders = ["/etc", "/usr/local/share", "/usr/share"].into_iter().chain(data.split(':'));
    for folder in folders.filter(|folder| !folder.is_empty()) {
        let Ok(entries) = fs::read_dir(Path::new(folder).join("vulkan/icd.d")) else { continue };
        for entry in entries {
            let entry = entry?;
            let name = entry.file_name().to_string_lossy().into_owned();
            if name.starts_with("radeon_icd") && (!name.contains("i686") || cfg!(target_arch = "x86")) {
                return Ok(entry.path());
            }
        }
    }
    Err("Mesa's RADV is not installed (Debian package mesa-vulkan-drivers)".into())
}

/// Compiles the kernels of a folder for the GPU of the environment. The driver and each kernel's statistics as JSON.
fn compile_all(folder: &Path, shows_code: bool) -> Result<Value> {
    let index: Value = serde_json::from_slice(&fs::read(folder.join("index.json"))?)?;
    // SAFETY: every call gets what Vulkan 1.3 asks for, and what it makes lives until the process ends.
    unsafe {
        let entry = ash::Entry::load()?;
        let application = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_3);
        let instance = vk::InstanceCreateInfo::default().application_info(&application);
        let instance = entry.create_instance(&instance, None)?;
        let physical = instance.enumerate_physical_devices()?;
        let [physical] = physical[..] else {
            return Err(format!("expected one device, found {}: is this RADV?", physical.len()).into());
        };
        let mut about = vk::PhysicalDeviceDriverProperties::default();
        let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut about);
        instance.get_physical_device_properties2(physical, &mut properties);
        let version = properties.properties.api_version;
        // "Mesa 22.3.6": what a distribution adds is no other compiler.
        let driver = about.driver_info_as_c_str()?.to_string_lossy().into_owned();
        let driver = driver.split(['-', '(']).next().unwrap_or_default().trim().to_string();

        // What wgpu asks of RADV, as far as it changes code.
        let mut robustness = vk::PhysicalDeviceRobustness2FeaturesEXT::default();
        let mut vulkan_1_3 = vk::PhysicalDeviceVulkan13Features::default();
        let mut known = vk::PhysicalDeviceFeatures2::default().push_next(&mut robustness).push_next(&mut vulkan_1_3);
        instance.get_physical_device_features2(physical, &mut known);
        let zeroes = vulkan_1_3.shader_zero_initialize_workgroup_memory == vk::TRUE;
        if version < vk::API_VERSION_1_3 || robustness.robust_buffer_access2 == vk::FALSE || !zeroes {
            return Err(format!("{driver} is too old: wgpu would hand it other code").into());
        }
        let mut robustness = vk::PhysicalDeviceRobustness2FeaturesEXT::default()
            .robust_buffer_access2(true)
            .robust_image_access2(robustness.robust_image_access2 == vk::TRUE);
        let mut vulkan_1_3 =
            vk::PhysicalDeviceVulkan13Features::default().shader_zero_initialize_workgroup_memory(true);
        let mut statistics =
            vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default().pipeline_executable_info(true);
        let extensions = [ash::khr::pipeline_executable_properties::NAME, ash::ext::robustness2::NAME];
        let extensions = extensions.map(std::ffi::CStr::as_ptr);
        let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(0).queue_priorities(&[1.0])];
        let features = vk::PhysicalDeviceFeatures::default().robust_buffer_access(true);
        let device = vk::DeviceCreateInfo::default()
            .queue_create_infos(&queues)
            .enabled_extension_names(&extensions)
            .enabled_features(&features)
            .push_next(&mut robustness)
            .push_next(&mut vulkan_1_3)
            .push_next(&mut statistics);
        let device = instance.create_device(physical, &device, None)?;
        let executables = ash::khr::pipeline_executable_properties::Device::new(&instance, &device);

        let mut kernels = Vec::new();
        for kernel in index.as_array().into_iter().flatten() {
            kernels.push(statistics_of(&device, &executables, kernel, shows_code)?);
        }
        Ok(json!({"driver": driver, "kernels": kernels}))
    }
}

/// The code of a kernel in the GPU's assembly language.
///
/// # Safety
/// As of [`statistics_of`], of whose pipeline this is.
unsafe fn assembly(
    executables: &ash::khr::pipeline_executable_properties::Device,
    executable: &vk::PipelineExecutableInfoKHR,
) -> Result<Vec<u8>> {
    // SAFETY: the second call has room for as many bytes as the first has asked for.
    unsafe {
        let mut found = executables.get_pipeline_executable_internal_representations(executable)?;
        let mut texts: Vec<Vec<u8>> = found.iter().map(|one| vec![0; one.data_size]).collect();
        for (one, text) in found.iter_mut().zip(&mut texts) {
            one.p_data = text.as_mut_ptr().cast();
        }
        let again = executables.fp().get_pipeline_executable_internal_representations_khr;
        again(executables.device(), executable, &mut (found.len() as u32), found.as_mut_ptr()).result()?;
        let is_code = |one: &vk::PipelineExecutableInternalRepresentationKHR| {
            one.name_as_c_str().is_ok_and(|name| name.to_bytes() == b"Assembly")
        };
        let code = found.iter().position(is_code).ok_or("this driver shows no assembly")?;
        Ok(texts.swap_remove(code))
    }
}

/// Compiles a kernel. Its statistics by their names.
///
/// # Safety
/// The device must have the extension's feature and that of robust buffers.
unsafe fn statistics_of(
    device: &ash::Device,
    executables: &ash::khr::pipeline_executable_properties::Device,
    kernel: &Value,
    shows_code: bool,
) -> Result<Value> {
    let path = Path::new(kernel["file"].as_str().unwrap_or_default());
    let bytes = fs::read(path)?;
    let words = ash::util::read_spv(&mut std::io::Cursor::new(bytes))?;
    let binding = |binding: &Value| {
        let ty = match binding[1] == true {
            true => vk::DescriptorType::UNIFORM_BUFFER,
            false => vk::DescriptorType::STORAGE_BUFFER,
        };
        let number = binding[0].as_u64().unwrap_or_default() as u32;
        let binding = vk::DescriptorSetLayoutBinding::default().binding(number).descriptor_count(1);
        binding.descriptor_type(ty).stage_flags(vk::ShaderStageFlags::COMPUTE)
    };
    let bindings: Vec<_> = kernel["bindings"].as_array().into_iter().flatten().map(binding).collect();
    let entry_point = CString::new(kernel["entry_point"].as_str().unwrap_or_default())?;
    // SAFETY: the kernel is valid SPIR-V (spirv-val), and its layout has all of its bindings.
    unsafe {
        let set = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
        let sets = [device.create_descriptor_set_layout(&set, None)?];
        let layout =
            device.create_pipeline_layout(&vk::PipelineLayoutCreateInfo::default().set_layouts(&sets), None)?;
        let module = device.create_shader_module(&vk::ShaderModuleCreateInfo::default().code(&words), None)?;
        let stage = vk::PipelineShaderStageCreateInfo::default()
            .stage(vk::ShaderStageFlags::COMPUTE)
            .module(module)
            .name(&entry_point);
        let mut flags = vk::PipelineCreateFlags::CAPTURE_STATISTICS_KHR;
        if shows_code {
            flags |= vk::PipelineCreateFlags::CAPTURE_INTERNAL_REPRESENTATIONS_KHR;
        }
        let pipeline = vk::ComputePipelineCreateInfo::default().flags(flags).layout(layout).stage(stage);
        let pipelines = device.create_compute_pipelines(vk::PipelineCache::null(), &[pipeline], None);
        let pipelines = pipelines.map_err(|(_, error)| error)?;
        let [pipeline] = pipelines[..] else { return Err("expected one pipeline".into()) };
        let executable = vk::PipelineExecutableInfoKHR::default().pipeline(pipeline);
        if shows_code {
            fs::write(path.with_extension("s"), assembly(executables, &executable)?)?;
        }
        let mut found = serde_json::Map::new();
        for statistic in executables.get_pipeline_executable_statistics(&executable)? {
            // RADV has unsigned ones only; a number of another kind is not read as one.
            if statistic.format == vk::PipelineExecutableStatisticFormatKHR::UINT64 {
                found.insert(statistic.name_as_c_str()?.to_string_lossy().into_owned(), statistic.value.u64.into());
            }
        }
        Ok(found.into())
    }
}

//! A report as text for a terminal.

use std::collections::BTreeMap;

use super::PathField;
use super::report::{Buffer, Constant, KernelReport, Module, Report};
use crate::gpu::buffers::LEAST;
use crate::gpu::link::Reason;

impl Report {
    /// The summary of the plan.
    pub fn text(&self) -> String {
        let mut out = String::new();
        out += "\nfeatures of the scene, and where each is used first\n";
        out += &table(self.features.iter().map(|(name, reason)| vec![name.clone(), reason.clone()]), &[]);
        let answers =
            self.choices.iter().map(|choice| format!("{} {}", choice.name.replace('_', " "), choice.answer()));
        out += &paragraph("chosen", answers);
        if !self.left_out.is_empty() {
            out += &paragraph("not linked", by_last_word(&self.left_out));
        }

        out += "\nkernels\n";
        out += &self.kernel_table();
        out += &format!("  integrator: {}\n", self.integrator);
        out += &format!("  scatter: {}\n", self.scatter);

        out += &format!("\npath state: {} bytes per slot\n", self.path_bytes());
        out += &table(by_reason(&self.path_fields), &[0]);

        out += "\nconstants\n";
        out += &constant_table(&self.constants.iter().collect::<Vec<_>>());

        let [uniform, storage] = self.limits;
        let total = self.gpu_bytes();
        out += &format!(
            "\nbuffers: {total} bytes on the device, at least {LEAST} each; it allows {uniform} per uniform binding, {storage} per \
             storage binding\n"
        );
        out += &buffer_rows(self.buffers.iter().map(|buffer| (buffer, None)));
        out
    }

    /// The modules, constants and fields of a kernel, each with its reason; `None` if there is no kernel of that name.
    pub fn why(&self, name: &str) -> Option<String> {
        let kernel = self.kernels.iter().find(|kernel| kernel.name == name)?;
        let mut out = format!("\n{name}: for {}\n", kernel.why);
        if let Some(size) = kernel.size {
            let wgsl = kernel.wgsl_bytes;
            let (instructions, bytes) = (size.instructions, size.bytes);
            out += &format!("  {instructions} instructions and {bytes} bytes of SPIR-V, {wgsl} bytes of WGSL\n");
        }
        let modules = &kernel.modules;
        out += &format!(
            "\nmodules: {} files of shaders/, each below the one that uses it, and its reason\n",
            modules.len()
        );
        let row = |module: &Module| {
            let indent = "  ".repeat(depth(modules, module));
            vec![format!("{indent}{}", module.name), module.reason.clone().unwrap_or_default()]
        };
        out += &table(modules.iter().map(row), &[]);

        out += "\nbindings: bytes and what they are\n";
        let bound = kernel.bindings.iter().filter_map(|(name, kind)| {
            let buffer = self.buffers.iter().find(|buffer| buffer.name == name)?;
            Some((buffer, Some(*kind)))
        });
        out += &buffer_rows(bound);
        out += &storage_notice(kernel);

        if !kernel.path_fields.is_empty() {
            out += "\npath state that it loads or stores\n";
            let row = |field: &PathField| {
                vec![field.label(), format!("{} bytes", field.bytes()), field.what.to_string(), field.why.clone()]
            };
            out += &table(kernel.path_fields.iter().map(row), &[1]);
        }

        out += "\nconstants\n";
        out += &constant_table(&self.constants_of(name));
        Some(out)
    }

    fn kernel_table(&self) -> String {
        let measured = self.kernels.iter().any(|kernel| kernel.size.is_some());
        let sizes =
            |kernel: &KernelReport| kernel.size.map(|size| [size.instructions, size.bytes].map(|n| n.to_string()));
        let header = ["", "instructions", "SPIR-V bytes", "modules", "buffers", "for"].map(str::to_string);
        let row = |kernel: &KernelReport| {
            let [instructions, bytes] = sizes(kernel).unwrap_or_default();
            let modules = kernel.modules.len().to_string();
            let buffers = kernel.bindings.len().to_string();
            let always = (kernel.features.is_empty() || kernel.why == Reason::EveryRender.to_string())
                .then(|| kernel.why.clone());
            let reason: Vec<String> = always.into_iter().chain(by_last_word(&kernel.features)).collect();
            [kernel.name.clone(), instructions, bytes, modules, buffers, reason.join(", ")]
        };
        let rows = std::iter::once(header).chain(self.kernels.iter().map(row)).map(|row| {
            let keep = |(i, cell)| (measured || ![1, 2].contains(&i)).then_some(cell);
            row.into_iter().enumerate().filter_map(keep).collect::<Vec<_>>()
        });
        let right: &[usize] = if measured { &[1, 2, 3, 4] } else { &[1, 2] };
        let notices: String = self.kernels.iter().map(storage_notice).collect();
        table(rows, right) + &notices
    }
}

/// Says that a kernel binds more storage buffers than the device allows.
fn storage_notice(kernel: &KernelReport) -> String {
    let (bound, limit) = (kernel.storage_buffers(), kernel.storage_limit);
    match bound > limit {
        true => {
            format!("  OVER THE LIMIT: {} binds {bound} storage buffers, and the device allows {limit}\n", kernel.name)
        }
        false => String::new(),
    }
}

/// The depth of a module below the kernel's root.
fn depth(modules: &[Module], module: &Module) -> usize {
    let user_of = |name: &str| modules.iter().find(|module| module.name == name)?.used_by.as_deref();
    // A chain is no longer than there are modules.
    std::iter::successors(module.used_by.as_deref(), |name| user_of(name)).take(modules.len()).count()
}

/// A row for each reason, with its fields.
fn by_reason(fields: &[PathField]) -> Vec<Vec<String>> {
    let mut rows: Vec<(&str, u64, Vec<String>)> = Vec::new();
    for field in fields {
        let named = format!("{} {}", field.label(), field.bytes());
        match rows.iter_mut().find(|(why, ..)| *why == field.why) {
            Some((_, bytes, names)) => {
                *bytes += field.bytes();
                names.push(named);
            }
            None => rows.push((&field.why, field.bytes(), vec![named])),
        }
    }
    rows.into_iter()
        .map(|(why, bytes, names)| vec![bytes.to_string(), format!("{}: {why}", names.join(", "))])
        .collect()
}

/// Joins "noise texture" and "marble texture", one after the other, to "noise/marble texture".
fn by_last_word(names: &[String]) -> Vec<String> {
    let mut groups: Vec<(Vec<&str>, Option<&str>)> = Vec::new();
    for name in names {
        let (first, last) = name.rsplit_once(' ').map_or((name.as_str(), None), |(first, last)| (first, Some(last)));
        match groups.last_mut() {
            Some((firsts, of_group)) if last.is_some() && *of_group == last => firsts.push(first),
            _ => groups.push((vec![first], last)),
        }
    }
    let joined = |(firsts, last): (Vec<&str>, Option<&str>)| {
        firsts.join("/") + &last.map(|last| format!(" {last}")).unwrap_or_default()
    };
    groups.into_iter().map(joined).collect()
}

/// A row for each constant, and one for the sizes of all tables.
fn constant_table(constants: &[&Constant]) -> String {
    let is_table = |constant: &&&Constant| constant.name.starts_with("size_of_");
    let mut values: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    constants.iter().for_each(|constant| values.entry(&constant.name).or_default().push(&constant.value));
    let row = |constant: &&Constant| {
        let value = values.remove(constant.name.as_str())?.join(", ");
        let name = constant.name.to_lowercase().replace('_', " ");
        Some(vec![name, value, constant.what.clone(), constant.reason.clone()])
    };
    let rows: Vec<_> = constants.iter().filter(|constant| !is_table(constant)).filter_map(row).collect();
    let tables = constants.iter().filter(is_table);
    let sizes: Vec<String> =
        tables.map(|table| format!("{} {}", table.name.trim_start_matches("size_of_"), table.value)).collect();
    let mut out = table(rows, &[1]);
    if !sizes.is_empty() {
        out += &paragraph("capacity of uniform tables", sizes);
    }
    out
}

/// Two lines for each buffer, so that they fit a terminal: its bytes and what it holds; how it is bound, and what needs it. A kind that is given
/// takes the place of the plan's.
fn buffer_rows<'a>(buffers: impl Iterator<Item = (&'a Buffer, Option<&'a str>)>) -> String {
    let rows = buffers.flat_map(|(buffer, kind)| {
        let over = match buffer.fits() {
            true => String::new(),
            false => format!("; OVER THE LIMIT: the device allows {} bytes", buffer.limit),
        };
        let kind = kind.unwrap_or(buffer.binding);
        // A purpose that only repeats the name, such as that of `spheres`, is left out.
        let what = if buffer.what == buffer.name { String::new() } else { buffer.what.to_string() };
        let how = format!("{kind}, {}: {}{over}", buffer.size, buffer.reason);
        [vec![buffer.name.to_string(), buffer.bytes.to_string(), what], vec![String::new(), String::new(), how]]
    });
    table(rows, &[1])
}

/// Rows with their columns aligned, the `right` ones at their ends.
fn table(rows: impl IntoIterator<Item = Vec<String>>, right: &[usize]) -> String {
    let rows: Vec<Vec<String>> = rows.into_iter().collect();
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max();
    let widths: Vec<usize> = (0..columns).map(|column| width(column).unwrap_or(0)).collect();
    let line = |row: &Vec<String>| {
        let cells = row.iter().enumerate().zip(&widths).map(|((column, cell), width)| match right.contains(&column) {
            true => format!("  {cell:>width$}"),
            false => format!("  {cell:<width$}"),
        });
        cells.collect::<String>().trim_end().to_string() + "\n"
    };
    rows.iter().map(line).collect()
}

/// "  name: item, item, …", which the terminal breaks into lines.
fn paragraph(name: &str, items: impl IntoIterator<Item = String>) -> String {
    let items: Vec<String> = items.into_iter().collect();
    format!("  {name}: {}\n", items.join(", "))
}

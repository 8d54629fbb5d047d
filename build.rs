//! Writes what src/data.rs includes: the constants of shaders/data, and its structs that a binding of shaders/bind holds. WGSL is their source.
//!
//! The host has all members of a struct, also those that only some kernels have; but an array that only some kernels have, and whose
//! length the plan sets, follows the host's struct. Other lengths that the plan sets are constants of src/data.rs: `${film_sums}` is
//! `FILM_SUMS`. A constant whose value is no number, such as one that the plan sets, is the shaders' alone.

use std::path::{Path, PathBuf};
use std::{env, fs};

fn main() {
    println!("cargo::rerun-if-changed=shaders/data\ncargo::rerun-if-changed=shaders/bind");
    if let Err(message) = write() {
        println!("cargo::error={message}");
    }
}

fn write() -> Result<(), String> {
    let bindings: String = files("shaders/bind")?.into_iter().map(|(_, text)| text).collect();
    let bindings: String = bindings.lines().filter(|line| line.contains("@binding(")).collect();
    let mut host = Host::default();
    for (path, text) in files("shaders/data")? {
        host.add(&path, &text, &bindings)?;
    }
    let out = env::var_os("OUT_DIR").ok_or("cargo sets no OUT_DIR")?;
    fs::write(Path::new(&out).join("data.rs"), host.text()).map_err(|error| error.to_string())
}

/// The files of a folder in the order of their names, each with its text.
fn files(folder: &str) -> Result<Vec<(String, String)>, String> {
    let fault = |error| format!("{folder}: {error}");
    let entries = fs::read_dir(folder).map_err(fault)?.collect::<Result<Vec<_>, _>>().map_err(fault)?;
    let mut paths: Vec<PathBuf> = entries.into_iter().map(|entry| entry.path()).collect();
    paths.sort();
    let file = |path: PathBuf| Ok((path.display().to_string(), fs::read_to_string(&path).map_err(fault)?));
    paths.into_iter().map(file).collect()
}

/// The host's side of modules, in Rust.
#[derive(Default)]
pub struct Host {
    items: String,
    /// The entries of the lists that tests compare with naga's reflection.
    constants: String,
    structs: String,
}

impl Host {
    /// Adds a module's constants, and its structs that `bindings` names.
    ///
    /// # Errors
    /// A member that the host cannot have, with its file and line.
    pub fn add(&mut self, path: &str, text: &str, bindings: &str) -> Result<(), String> {
        let (mut docs, mut in_struct, mut is_conditional) = (String::new(), false, false);
        for (number, line) in (1..).zip(text.lines()) {
            let (code, comment) = line.split_once("//").unwrap_or((line, ""));
            let code = code.trim_end();
            if let Some(directive) = comment.strip_prefix("@ ") {
                is_conditional = directive.starts_with("if ");
                continue;
            } else if code.is_empty() && !comment.is_empty() {
                docs += &format!("///{comment}\n");
                continue;
            }
            let docs = std::mem::take(&mut docs);
            if let Some(name) = code.strip_prefix("struct ").and_then(|rest| rest.strip_suffix(" {")) {
                in_struct = bindings.split(|c| !is_of_word(c)).any(|word| word == name);
                if in_struct {
                    self.items += &format!("device_struct!(\n{docs}{name} {{\n");
                    self.structs += &format!("(\"{name}\", size_of::<{name}>(), {name}::FIELDS),\n");
                }
            } else if in_struct && code == "}" {
                self.items += "});\n";
                in_struct = false;
            } else if in_struct && !code.is_empty() {
                let code = code.trim();
                let member = member(code).ok_or_else(|| {
                    format!("{path}:{number}: the host cannot have `{code}`: expected u32, i32, f32, or vectors, atomics or arrays of them")
                })?;
                if !(is_conditional && code.contains("${")) {
                    self.items += &format!("{docs}{member},\n");
                }
            } else if let Some((name, ty, value)) = constant(code) {
                self.items += &format!("{docs}pub const {name}: {ty} = {value}_{ty};\n");
                if ty == "u32" {
                    self.constants += &format!("(\"{name}\", {name}),\n");
                }
            }
        }
        Ok(())
    }

    pub fn text(&self) -> String {
        let Host { items, constants, structs } = self;
        format!(
            "{items}/// The constants of type u32, by name.\npub const CONSTANTS: &[(&str, u32)] = &[\n{constants}];\n\
             /// The structs by name, with their bytes and fields.\npub const STRUCTS: &[(&str, usize, Fields)] = &[\n{structs}];\n"
        )
    }
}

fn is_of_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// The name, type and value of a constant that is a number.
fn constant(code: &str) -> Option<(&str, &str, &str)> {
    let (name, rest) = code.strip_prefix("const ")?.split_once(": ")?;
    let (ty, value) = rest.split_once(" = ")?;
    // Its type begins with the suffix of a number.
    let value = value.strip_suffix(';')?.trim_end_matches(ty.get(..1)?);
    let is_hex = value.strip_prefix("0x").is_some_and(|digits| u32::from_str_radix(digits, 16).is_ok());
    (["u32", "i32", "f32"].contains(&ty) && (is_hex || value.parse::<f32>().is_ok())).then_some((name, ty, value))
}

fn member(code: &str) -> Option<String> {
    let (name, ty) = code.trim_end_matches(',').split_once(": ")?;
    name.chars().all(is_of_word).then_some(format!("{name}: {}", host_type(ty)?))
}

fn host_type(ty: &str) -> Option<String> {
    if ["u32", "i32", "f32"].contains(&ty) {
        return Some(ty.to_string());
    }
    let (generic, inside) = ty.strip_suffix('>')?.split_once('<')?;
    let (element, length) = match generic {
        "atomic" => return host_type(inside),
        "vec2" | "vec3" | "vec4" => (inside, generic.get(3..)?),
        "array" => inside.rsplit_once(", ")?,
        _ => return None,
    };
    let length = match length.strip_prefix("${").and_then(|value| value.strip_suffix('}')) {
        Some(value) => value.to_uppercase(),
        None if length.starts_with(char::is_numeric) => length.trim_end_matches('u').to_string(),
        None => format!("{length} as usize"),
    };
    Some(format!("[{}; {length}]", host_type(element)?))
}

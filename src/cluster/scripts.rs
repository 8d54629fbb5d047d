//! The scripts of the folder: a task, and the join of its parts.

use std::path::Path;

use super::{Folder, LOG, MERGE, PARTS, RENDER};
use crate::error::{Error, Result};
use crate::output::atomic;

const RENDER_TEXT: &str = include_str!("render.sh");
const MERGE_TEXT: &str = include_str!("merge.sh");

impl Folder {
    /// Writes what the tasks need, so many of them: the list of parts, and the scripts for the program at this path.
    pub fn write_scripts(&self, program: &Path, tasks: u32) -> Result<()> {
        for folder in [self.path.join(PARTS), self.path.join(LOG)] {
            std::fs::create_dir_all(&folder).map_err(Error::file(&folder, "write"))?;
        }
        let lines: String = self.parts().map(|part| format!("{}..{}\n", part.start, part.end)).collect();
        atomic::write(&self.path.join("parts.txt"), lines.as_bytes())?;
        self.write_script(RENDER, &render(self, program, tasks)?)?;
        self.write_script(MERGE, &merge(self, program)?)
    }

    fn write_script(&self, name: &str, text: &str) -> Result<()> {
        let path = self.path.join(name);
        atomic::write(&path, text.as_bytes())?;
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let executable = |mode: u32| mode | (mode & 0o444) >> 2;
            std::fs::metadata(&path)
                .map(|found| executable(found.permissions().mode()))
                .and_then(|mode| std::fs::set_permissions(&path, std::fs::Permissions::from_mode(mode)))
                .map_err(Error::file(&path, "write"))?;
        }
        Ok(())
    }
}

/// A text as one word of the shell.
pub fn quoted(text: &str) -> String {
    format!("'{}'", text.replace('\'', r"'\''"))
}

/// A path as text.
///
/// # Errors
/// `Error::Usage` where it is not Unicode, which neither scripts nor JSON can hold.
pub fn text_of(path: &Path) -> Result<&str> {
    path.to_str().ok_or_else(|| Error::Usage(format!("{}: expected a path in Unicode", path.display())))
}

/// Words of a command line, as the shell reads them.
pub fn line(words: &[String]) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_=./:%@+,".contains(c);
    let word = |word: &String| match !word.is_empty() && word.chars().all(plain) {
        true => word.clone(),
        false => quoted(word),
    };
    words.iter().map(word).collect::<Vec<_>>().join(" ")
}

/// The words as the shell reads them, each behind a space.
fn after_space(words: &[String]) -> String {
    words.iter().map(|word| format!(" {}", line(std::slice::from_ref(word)))).collect()
}

/// The beginning of each script, for the program at this path: shell variables with their values, each on its line.
fn beginning(folder: &Folder, program: &Path, values: &[(&str, &str)]) -> Result<String> {
    let own = [("folder", text_of(&folder.path)?), ("gpu_rt", text_of(program)?)];
    let values = own.iter().chain(values).map(|(name, value)| format!("{name}={}\n", quoted(value)));
    let values: String = values.collect();
    Ok(format!("#!/bin/sh\n{values}gpu_rt=${{GPU_RT:-$gpu_rt}}\n"))
}

/// The script of a task, of so many.
fn render(folder: &Folder, program: &Path, tasks: u32) -> Result<String> {
    let options = &folder.request.options;
    let digits = folder.digits();
    let beginning = beginning(
        folder,
        program,
        &[
            ("scene", text_of(&folder.request.scene)?),
            ("name", &format!("parts/%0{digits}d-%0{digits}d.exr")),
            ("tasks", &tasks.to_string()),
            ("device", if options.iter().any(|word| word == "--device") { "given" } else { "auto" }),
        ],
    )?;
    let task = "task=${SLURM_ARRAY_TASK_ID:-${1:-}}\n";
    Ok(format!("{beginning}{task}set --{}\n{RENDER_TEXT}", after_space(options)))
}

/// The script that joins the parts.
fn merge(folder: &Folder, program: &Path) -> Result<String> {
    let request = &folder.request;
    let noise = request.noise.map(|noise| noise.to_string()).unwrap_or_default();
    let [start, end] = request.samples;
    let beginning = beginning(
        folder,
        program,
        &[("samples", &format!("{start}..{end}")), ("output", text_of(&request.output)?), ("noise", &noise)],
    )?;
    let mixed = request.options.iter().filter(|word| *word == "--mixed-drivers").cloned();
    let error = (!noise.is_empty()).then(|| ["--noise".to_string(), noise.clone()]);
    let options: Vec<String> = mixed.chain(error.into_iter().flatten()).collect();
    Ok(format!("{beginning}set --{}\n{MERGE_TEXT}", after_space(&options)))
}

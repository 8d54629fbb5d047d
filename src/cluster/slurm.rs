//! Slurm's commands: what a folder's tasks are given to.

use std::path::Path;
use std::process::{Command, Stdio};

use super::scripts::{line, text_of};
use super::{Folder, LOG, MERGE, RENDER};
use crate::error::{Error, Result};
use crate::output::destination::is_on_path;

/// The tasks of an array if the cluster does not report its limit: Slurm's default.
const TASKS: u32 = 1001;

/// A cluster, or none, for which scripts are written.
pub struct Slurm {
    there: bool,
    /// The most tasks of an array.
    pub most_tasks: u32,
}

/// The numbers of the two jobs.
pub struct Ids {
    /// `None` if no part is missing.
    pub array: Option<String>,
    pub merge: String,
}

impl Slurm {
    /// Finds the cluster of this machine.
    ///
    /// # Errors
    /// `Error::File` where there is no sbatch, unless nothing is to be submitted.
    pub fn find(dry_run: bool) -> Result<Slurm> {
        let there = is_on_path("sbatch");
        if !there && !dry_run {
            return Err(Error::file("sbatch", "run")(
                "it is not on the PATH. Run this on a machine that can submit to Slurm; or add --dry-run, which writes the folder and its \
                 scripts, to run them by Slurm, GNU parallel or by hand",
            ));
        }
        let most_tasks = if there { most_tasks() } else { Some(TASKS) };
        Ok(Slurm { there: there && !dry_run, most_tasks: most_tasks.unwrap_or(TASKS).max(1) })
    }

    /// Submits these tasks of the folder, and the join after them. Without a cluster, it passes the lines to `tell`.
    pub fn submit(
        &self,
        folder: &Folder,
        tasks: &[u32],
        tell: &mut dyn FnMut(&str) -> Result<()>,
    ) -> Result<Option<Ids>> {
        let stem = folder.request.output.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let at = text_of(&folder.path)?;
        // Options of the user may replace these.
        let common = |name: String, log: &str| {
            let ours = [
                format!("--job-name={name}"),
                format!("--chdir={at}"),
                format!("--output={LOG}/{log}.out"),
                "--open-mode=append".to_string(),
                "--requeue".to_string(),
            ];
            ours.into_iter()
        };
        let user = || folder.request.sbatch.iter().cloned();
        let script = |name: &str| text_of(&folder.path.join(name)).map(str::to_string);
        let mut array = None;
        if !tasks.is_empty() {
            let words: Vec<String> = common(stem.clone(), "%A_%a")
                .chain(["--signal=B:TERM@120".to_string()])
                .chain(user())
                .chain([format!("--array={}", ranges(tasks)), "--parsable".to_string(), script(RENDER)?])
                .collect();
            array = Some(self.sbatch(words, "ARRAY", tell)?);
        }
        let after = array.iter().map(|id| format!("--dependency=afterany:{id}"));
        let words: Vec<String> = common(format!("{stem}-merge"), "merge_%j")
            .chain(user())
            .chain(after)
            .chain(["--parsable".to_string(), script(MERGE)?])
            .collect();
        let merge = self.sbatch(words, "MERGE", tell).map_err(|error| match &array {
            Some(id) => Error::File {
                path: "sbatch".into(),
                action: "run",
                reason: format!("{error}. The array {id} has been submitted; run {MERGE} after it, or `scancel {id}`"),
            },
            None => error,
        })?;
        Ok(self.there.then_some(Ids { array, merge }))
    }

    /// The number of the job that Slurm makes of this.
    fn sbatch(&self, words: Vec<String>, dry: &str, tell: &mut dyn FnMut(&str) -> Result<()>) -> Result<String> {
        if !self.there {
            tell(&format!("sbatch {}", line(&words)))?;
            return Ok(dry.to_string());
        }
        let failed = Error::file("sbatch", "run");
        let ran = Command::new("sbatch").args(&words).stdin(Stdio::null()).output();
        let ran = ran.map_err(|error| failed(error.to_string()))?;
        let said = String::from_utf8_lossy(&ran.stdout);
        // With several clusters: the number, and the name of one.
        let id = said.lines().last().unwrap_or_default().split(';').next().unwrap_or_default().trim();
        match ran.status.success() && !id.is_empty() && id.chars().all(|c| c.is_ascii_digit()) {
            true => Ok(id.to_string()),
            false => Err(failed(
                format!("{} {}", String::from_utf8_lossy(&ran.stderr).trim(), said.trim()).trim().to_string(),
            )),
        }
    }
}

/// The most tasks of an array, if Slurm reports it.
fn most_tasks() -> Option<u32> {
    let ran = Command::new("scontrol").args(["show", "config"]).stdin(Stdio::null()).output().ok()?;
    let said = String::from_utf8_lossy(&ran.stdout);
    let (_, value) =
        said.lines().filter_map(|line| line.split_once('=')).find(|(name, _)| name.trim() == "MaxArraySize")?;
    value.trim().parse().ok()
}

/// Numbers in order as Slurm takes them: 0-3,7.
fn ranges(numbers: &[u32]) -> String {
    let runs = numbers.chunk_by(|a, b| a + 1 == *b);
    let words = runs.map(|run| match run {
        [first, .., last] => format!("{first}-{last}"),
        run => run.iter().map(u32::to_string).collect(),
    });
    words.collect::<Vec<_>>().join(",")
}

/// Removes the counts of tries of tasks that are submitted anew.
pub fn forget_tries(folder: &Path, tasks: &[u32]) {
    for task in tasks {
        // Most have none.
        let _ = std::fs::remove_file(folder.join(LOG).join(format!("{task}.tries")));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_list_ranges() {
        for (numbers, words) in
            [(vec![3], "3"), (vec![0, 1, 2, 3], "0-3"), (vec![0, 2, 3, 7], "0,2-3,7"), (vec![5, 6], "5-6")]
        {
            assert_eq!(ranges(&numbers), words);
        }
    }
}

//! The folder of a render that many processes share: the request, its parts, and where their images are.
//!
//! `gpu-rt submit` writes it, `gpu-rt status` reads it.

pub mod parts;
pub mod scripts;
pub mod slurm;
pub mod split;

use std::ops::Range;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::data::RUN_LENGTH;
use crate::error::{Error, Result};
use crate::output::atomic;
use crate::output::exr::read_state;

/// The file with the request.
pub const JOB_FILE: &str = "job.json";
const PARTS: &str = "parts";
/// The script of a task, and that of the join.
pub const RENDER: &str = "render.sh";
pub const MERGE: &str = "merge.sh";
/// Where tasks write what they say, and how often they were tried.
pub const LOG: &str = "log";
/// The version of the format. A reader refuses others.
pub const FORMAT: u32 = 1;

/// The folder and its request.
#[derive(Clone, Debug, PartialEq)]
pub struct Folder {
    pub path: PathBuf,
    pub request: ClusterRequest,
}

/// The request to all processes together: `job.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClusterRequest {
    pub format: u32,
    /// Of the program that wrote it.
    pub version: String,
    /// The scene file, from the folder.
    pub scene: PathBuf,
    /// The image of all parts, from the folder.
    pub output: PathBuf,
    /// All samples: with an error to reach, those of the rounds so far.
    pub samples: [u32; 2],
    /// The error to reach, and the most samples to reach it by.
    pub noise: Option<f64>,
    pub most: Option<u32>,
    /// The samples of each part, in order.
    pub parts: Vec<[u32; 2]>,
    /// With an error to reach: the parts that each round is split into.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub round: Option<u32>,
    pub width: u32,
    pub height: u32,
    /// The render's options, as words of the command line.
    pub options: Vec<String>,
    /// Options of sbatch.
    pub sbatch: Vec<String>,
}

impl Folder {
    /// Reads the request of this folder.
    ///
    /// # Errors
    /// `Error::File` with the file's name, where it cannot be read or is not what `gpu-rt submit` writes.
    pub fn read(path: &Path) -> Result<Folder> {
        let file = path.join(JOB_FILE);
        let failed = Error::file(&file, "read");
        let text = std::fs::read_to_string(&file)
            .map_err(|error| failed(format!("{error}. Is this a folder that `gpu-rt submit` has written?")))?;
        let json = serde_json::from_str::<serde_json::Value>(&text).map_err(|error| failed(error.to_string()))?;
        if json.get("format").and_then(serde_json::Value::as_u64) != Some(u64::from(FORMAT)) {
            return Err(failed(format!("it has another format than this version of gpu-rt reads ({FORMAT})")));
        }
        let request: ClusterRequest = serde_json::from_value(json).map_err(|error| failed(error.to_string()))?;
        request.check().map_err(failed)?;
        Ok(Folder { path: path.to_owned(), request })
    }

    /// Writes the request; a reader finds the old text or the new one.
    pub fn write(&self) -> Result<()> {
        let file = self.path.join(JOB_FILE);
        let json = serde_json::to_string_pretty(&self.request).map_err(Error::file(&file, "write"))?;
        atomic::write(&file, (json + "\n").as_bytes())
    }

    /// The parts that lack samples, by their numbers.
    ///
    /// # Errors
    /// `Error::File` with the name of one that cannot be read.
    pub fn missing(&self) -> Result<Vec<u32>> {
        let mut missing = Vec::new();
        for (number, part) in (0..).zip(self.parts()) {
            let path = self.part_path(&part);
            let state = if path.exists() { read_state(&path)? } else { None };
            if state.is_none_or(|state| !state.samples.missing(part).is_empty()) {
                missing.push(number);
            }
        }
        Ok(missing)
    }

    /// The samples of each part, in order.
    pub fn parts(&self) -> impl ExactSizeIterator<Item = Range<u32>> + '_ {
        self.request.parts.iter().map(|[start, end]| *start..*end)
    }

    /// The image of a part. The names are sorted as the parts are.
    pub fn part_path(&self, range: &Range<u32>) -> PathBuf {
        let digits = self.digits();
        self.path.join(PARTS).join(format!("{:0digits$}-{:0digits$}.exr", range.start, range.end))
    }

    /// The digits of the largest sample that may be requested, now or later.
    fn digits(&self) -> usize {
        self.request.most.unwrap_or(0).max(self.request.samples[1]).to_string().len()
    }

    /// The image of all parts.
    pub fn output(&self) -> PathBuf {
        self.path.join(&self.request.output)
    }
}

impl ClusterRequest {
    /// Checks that the parts follow one another and make up all samples.
    fn check(&self) -> std::result::Result<(), String> {
        let [mut at, end] = self.samples;
        for &[from, to] in &self.parts {
            if from != at || to <= from || !from.is_multiple_of(RUN_LENGTH) {
                return Err(format!("the part {from}..{to} does not go on where the one before ended, at {at}"));
            }
            at = to;
        }
        match at == end && !self.parts.is_empty() {
            true => Ok(()),
            false => Err(format!("the parts end at {at} instead of {end}")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(path: &Path) -> Folder {
        let request = ClusterRequest {
            format: FORMAT,
            scene: "scene/a b.ron".into(),
            output: "a b.exr".into(),
            samples: [0, 1000],
            parts: vec![[0, 504], [504, 1000]],
            width: 16,
            height: 9,
            ..ClusterRequest::default()
        };
        Folder { path: path.to_owned(), request }
    }

    #[test]
    fn a_request_is_read_as_it_was_written() {
        let folder_path = tempfile::tempdir().unwrap();
        let written = folder(folder_path.path());
        written.write().unwrap();
        assert_eq!(Folder::read(folder_path.path()).unwrap(), written);
        assert_eq!(written.part_path(&(0..504)), folder_path.path().join("parts/0000-0504.exr"));
        assert_eq!(written.output(), folder_path.path().join("a b.exr"));
    }

    #[test]
    fn a_damaged_request_is_refused_by_name() {
        let folder_path = tempfile::tempdir().unwrap();
        let file = folder_path.path().join(JOB_FILE);
        let refused = |word: &str| {
            let message = Folder::read(folder_path.path()).unwrap_err().to_string();
            assert!(message.starts_with(&file.display().to_string()) && message.contains(word), "{message}");
        };
        refused("submit");
        let written = folder(folder_path.path());
        written.write().unwrap();
        let text = std::fs::read_to_string(&file).unwrap();
        for (from, to, word) in [
            ("\"format\": 1", "\"format\": 2", "format"),
            ("\"format\": 1", "\"forma\": 1", "format"),
            ("\"noise\"", "\"noisy\"", "noisy"),
            ("{", "", "column"),
            ("1000\n", "2000\n", "2000"),
        ] {
            assert!(text.contains(from));
            std::fs::write(&file, text.replacen(from, to, 1)).unwrap();
            refused(word);
        }
        for parts in [vec![], vec![[0, 504]], vec![[0, 504], [512, 1000]], vec![[0, 500], [500, 1000]], vec![[8, 0]]] {
            let mut other = written.clone();
            other.request.parts = parts;
            other.write().unwrap();
            refused("part");
        }
    }
}

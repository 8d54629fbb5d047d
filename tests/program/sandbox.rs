//! What the tests of the program share: a scene, and folders to work in.

use crate::common::device::index as software;
use crate::common::program::{Ran, command, meanwhile, ran, words};
pub use crate::common::scenes::SPHERE;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command};

use gpu_rt::output::exr::{ExrImage, read_exr};
use tempfile::TempDir;

/// More samples than any machine renders in that time: a render of them ends only when it is refused or interrupted.
pub const ENDLESS: &str = "1000000000";

/// A folder with the scene `sphere.ron` in a folder of its own, and a folder to work in.
pub struct Sandbox {
    pub folder: TempDir,
}

impl Sandbox {
    pub fn new() -> Sandbox {
        let sandbox = Sandbox { folder: tempfile::tempdir().expect("a temporary folder") };
        fs::create_dir(sandbox.folder.path().join("scenes")).expect("a folder is made");
        fs::create_dir(sandbox.work()).expect("a folder is made");
        sandbox.scene("sphere.ron", SPHERE);
        sandbox
    }

    /// The current folder of the program.
    pub fn work(&self) -> PathBuf {
        self.folder.path().join("work")
    }

    /// A file in it.
    pub fn at(&self, name: impl AsRef<Path>) -> PathBuf {
        self.work().join(name)
    }

    /// Writes a scene; the result is its path from the work folder.
    pub fn scene(&self, name: &str, text: &str) -> String {
        let path = format!("../scenes/{name}");
        fs::write(self.at(&path), text).expect("the scene is written");
        path
    }

    pub fn command(&self, arguments: &[&str]) -> Command {
        command(&self.work(), arguments)
    }

    pub fn run(&self, arguments: &[&str]) -> Ran {
        ran(&mut self.command(arguments))
    }

    /// Runs a command line without quotes and spaces in its words.
    pub fn says(&self, line: &str) -> Ran {
        self.run(&words(line))
    }

    /// `gpu-rt render ../scenes/sphere.ron --device SOFTWARE`, and more arguments.
    pub fn render(&self, more: &[&str]) -> Ran {
        self.run(&[&self.render_sphere(), more].concat())
    }

    pub fn render_sphere(&self) -> [&'static str; 4] {
        ["render", "../scenes/sphere.ron", "--device", software()]
    }

    /// A render without end, which is refused within the limit. No file is made.
    #[track_caller]
    pub fn refuses(&self, more: &[&str]) -> Ran {
        let before = self.files();
        let ran = self.render(&[&["--spp", ENDLESS], more].concat()).exits(2);
        assert!(ran.last_line().ends_with("; nothing has been rendered"), "{}", ran.stderr);
        assert_eq!(self.files(), before, "{more:?}");
        ran
    }

    /// The files in the work folder.
    pub fn files(&self) -> Vec<String> {
        names(&self.work())
    }

    pub fn exr(&self, name: &str) -> ExrImage {
        read_exr(&self.at(name)).unwrap_or_else(|error| panic!("{error}"))
    }
}

/// The files in a folder.
pub fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("the folder is there");
    let mut names: Vec<String> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

pub fn attribute<'a>(image: &'a ExrImage, name: &str) -> &'a str {
    let found = image.attributes.iter().find(|(key, _)| key == name);
    found.map(|(_, value)| value.as_str()).unwrap_or_else(|| panic!("no {name} in {:?}", image.attributes))
}

/// Makes a pipe with a name.
#[cfg(unix)]
pub fn make_pipe(path: &Path) {
    let made = Command::new("mkfifo").arg(path).status().expect("mkfifo is there");
    assert!(made.success(), "the pipe is made");
}

/// Starts a render without end, with checkpoints all the time, and waits for the first of them.
pub fn endless(sandbox: &Sandbox, more: &[&str]) -> Child {
    let arguments = [&sandbox.render_sphere(), ["--spp", ENDLESS, "--checkpoint", "50ms"].as_slice(), more].concat();
    let written = || fs::metadata(sandbox.at("sphere.exr")).and_then(|found| found.modified()).ok();
    let before = written();
    let mut child = sandbox.command(&arguments).spawn().expect("the program starts");
    meanwhile(&mut child, || written().is_some_and(|time| Some(time) != before));
    child
}

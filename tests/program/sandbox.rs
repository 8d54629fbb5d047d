//! What the tests of the program share: a scene, and folders to work in.

use crate::common::device::index as software;
use crate::common::program::{Ran, command, finish, meanwhile};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command};

use gpu_rt::output::exr::{ExrImage, read_exr};
use tempfile::TempDir;

/// More samples than any machine renders in that time: a render of them ends only when it is refused or interrupted.
pub const ENDLESS: &str = "1000000000";

/// One Lambertian sphere before a gradient: nothing more than that is required.
pub const SPHERE: &str = "Scene(
    image: (width: 20, height: 12),
    camera: (look_from: (0, 0, 3), look_at: (0, 0, 0), up: (0, 1, 0), vertical_fov: 50),
    background: Gradient(bottom: (1, 1, 1), top: (0.5, 0.7, 1)),
    materials: { \"grey\": Lambertian(albedo: Rgb(0.5, 0.4, 0.3)) },
    objects: [Sphere(center: (0, 0, 0), radius: 1, material: \"grey\")],
    render: (samples: 16, max_depth: 7),
)
";

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
        finish(self.command(arguments).spawn().expect("the program starts"))
    }

    /// Runs a command line without quotes and spaces in its words.
    pub fn says(&self, line: &str) -> Ran {
        self.run(&line.split_whitespace().collect::<Vec<_>>())
    }

    /// `gpu-rt render ../scenes/sphere.ron --device SOFTWARE`, and more arguments.
    pub fn render(&self, more: &[&str]) -> Ran {
        self.run(&[&self.render_sphere(), more].concat())
    }

    pub fn render_sphere(&self) -> [&'static str; 4] {
        ["render", "../scenes/sphere.ron", "--device", software()]
    }

    /// The files in the work folder.
    pub fn files(&self) -> Vec<String> {
        let entries = fs::read_dir(self.work()).expect("the folder is there");
        let mut names: Vec<String> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    pub fn exr(&self, name: &str) -> ExrImage {
        read_exr(&self.at(name)).unwrap_or_else(|error| panic!("{error}"))
    }
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

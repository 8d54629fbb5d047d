//! Systems on which the program's driver, or its threads, fail: libraries of one file each (tests/layer), which the tests build.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

const LAYER: &str = "VK_LAYER_GPU_RT_fault";

/// A fault of the driver, and the file by which the layer says that it has happened.
#[derive(Debug)]
pub struct Fault {
    fault: String,
    mark: PathBuf,
}

impl Fault {
    /// A function of Vulkan returns `lost` or `memory` from this call on, or the device hangs from then on (`hang`), or does not do all that it
    /// says (`skip`, `half`). The mark lies in the folder.
    pub fn new(folder: &Path, function: &str, call: u32, result: &str) -> Fault {
        Fault { fault: format!("{function}:{call}:{result}:always"), mark: folder.join("fault") }
    }

    /// A fault that occurs once only: what opens the device again can go on.
    pub fn once(folder: &Path, function: &str, call: u32, result: &str) -> Fault {
        Fault { fault: format!("{function}:{call}:{result}:once"), mark: folder.join("fault") }
    }

    /// Lets the program meet the fault.
    pub fn put_under(&self, command: &mut Command) {
        let _ = std::fs::remove_file(&self.mark);
        put_layer_under(command);
        command.env("GPU_RT_FAULT", &self.fault).env("GPU_RT_FAULT_MARK", &self.mark);
    }

    pub fn has_happened(&self) -> bool {
        self.mark.exists()
    }
}

/// Puts the layer between the program and the driver.
pub fn put_layer_under(command: &mut Command) {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| {
        let library = library("fault");
        let manifest = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/layer/fault.json");
        std::fs::copy(manifest, library.with_extension("json")).expect("the manifest is copied");
        library.parent().expect("a folder").to_path_buf()
    });
    command.env("VK_LAYER_PATH", folder).env("VK_INSTANCE_LAYERS", LAYER);
}

/// Lets the program start no thread. The result is the file that exists once it has tried.
pub fn without_threads(command: &mut Command, folder: &Path) -> PathBuf {
    static LIBRARY: OnceLock<PathBuf> = OnceLock::new();
    let mark = folder.join("fault");
    let _ = std::fs::remove_file(&mark);
    command.env("LD_PRELOAD", LIBRARY.get_or_init(|| library("no_threads"))).env("GPU_RT_FAULT_MARK", &mark);
    mark
}

/// Lets the folder of the program be on a disk that is full as long as the file `full` exists.
pub fn on_full_disk(command: &mut Command, disk: &Path, full: &Path) {
    static LIBRARY: OnceLock<PathBuf> = OnceLock::new();
    command.env("LD_PRELOAD", LIBRARY.get_or_init(|| library("full_disk")));
    command.env("GPU_RT_DISK", disk).env("GPU_RT_DISK_IS_FULL", full);
}

/// The library of a file of tests/layer.
pub fn library(name: &str) -> PathBuf {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/layer").join(name).with_extension("rs");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("layer");
    std::fs::create_dir_all(&folder).expect("a folder is made");
    let library = folder.join(format!("lib{name}.so"));
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let mut build = Command::new(rustc);
    build.args(["--edition", "2024", "--crate-type", "cdylib", "-o"]).arg(&library).arg(source);
    let built = build.output().expect("rustc starts");
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    library
}

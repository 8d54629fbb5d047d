//! GPUs that the system has, but no Vulkan driver for: mostly in containers, which share a GPU's files with or without its drivers.

use std::path::{Path, PathBuf};

/// What is missing, and what to do, if the system has a GPU. Only for where no adapter is a GPU.
pub fn unseen_gpu() -> Option<String> {
    let capabilities = std::env::var("NVIDIA_DRIVER_CAPABILITIES").ok();
    missing(Path::new("/"), capabilities.as_deref())
}

/// Where systems and containers keep the file that names NVIDIA's Vulkan driver.
const MANIFESTS: [&str; 4] = [
    "etc/vulkan/icd.d/nvidia_icd.json",
    "usr/share/vulkan/icd.d/nvidia_icd.json",
    "usr/local/nvidia/share/vulkan/icd.d/nvidia_icd.json",
    "usr/local/nvidia/vulkan/icd.d/nvidia_icd.json",
];

fn missing(root: &Path, capabilities: Option<&str>) -> Option<String> {
    let devices = root.join("dev");
    if let Some(gpu) = first_numbered(&devices, "nvidia") {
        let gpu = gpu.display();
        if let Some(manifest) = MANIFESTS.into_iter().map(|path| root.join(path)).find(|path| path.exists()) {
            let manifest = manifest.display();
            return Some(format!(
                "{gpu} is a GPU whose Vulkan driver does not open: {manifest} names it. It needs GLVND (on Debian or Ubuntu `apt-get install \
                 libgl1 libegl1`), and the Vulkan loader may have to be told where it is: VK_DRIVER_FILES={manifest}"
            ));
        }
        let has_graphics = |list: &str| list.split(',').any(|word| matches!(word.trim(), "graphics" | "all"));
        return Some(match capabilities.filter(|list| !has_graphics(list)) {
            Some(list) => format!(
                "{gpu} is a GPU, and this container lacks its Vulkan driver: start it with NVIDIA_DRIVER_CAPABILITIES={list},graphics"
            ),
            None => format!(
                "{gpu} is a GPU without a Vulkan driver: install that of NVIDIA (the file nvidia_icd.json names it), and start a \
                 container with NVIDIA_DRIVER_CAPABILITIES=all"
            ),
        });
    }
    let gpu = first_numbered(&devices.join("dri"), "renderD")?;
    Some(format!(
        "{} is a GPU without a Vulkan driver that opens it: install one (on Debian or Ubuntu `apt-get install mesa-vulkan-drivers`), and \
         let this user read and write that file",
        gpu.display()
    ))
}

/// The first file of a folder whose name is this and a number.
fn first_numbered(folder: &Path, name: &str) -> Option<PathBuf> {
    let is_number = |rest: &str| !rest.is_empty() && rest.bytes().all(|byte| byte.is_ascii_digit());
    let entries = std::fs::read_dir(folder).ok()?.flatten();
    let named = entries
        .filter(|entry| entry.file_name().to_str().and_then(|own| own.strip_prefix(name)).is_some_and(is_number));
    named.map(|entry| entry.path()).min()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_gpu_lacks_is_told_by_its_files() {
        let system = |files: &[&str]| {
            let folder = tempfile::tempdir().expect("a folder");
            for file in files {
                let path = folder.path().join(file);
                std::fs::create_dir_all(path.parent().expect("a folder")).expect("it is made");
                std::fs::write(path, "").expect("it is written");
            }
            folder
        };
        let none = system(&["dev/nvidiactl", "dev/nvidia-uvm", "dev/dri/card0", "dev/null"]);
        assert_eq!(missing(none.path(), Some("compute")), None);
        let nvidia = system(&["dev/nvidia1", "dev/nvidia0", "dev/dri/renderD128"]);
        let told = |capabilities| missing(nvidia.path(), capabilities).expect("there is a GPU");
        assert!(told(Some("compute,utility")).ends_with("NVIDIA_DRIVER_CAPABILITIES=compute,utility,graphics"));
        for capabilities in [Some("all"), Some("compute, graphics"), None] {
            assert!(told(capabilities).contains("nvidia0 is a GPU without a Vulkan driver"), "{capabilities:?}");
        }
        for manifest in MANIFESTS {
            let closed = system(&["dev/nvidia0", manifest]);
            let told = missing(closed.path(), Some("compute")).expect("there is a GPU");
            assert!(told.contains("libgl1") && told.ends_with(manifest), "{told}");
        }
        let other = system(&["dev/dri/renderD128"]);
        assert!(missing(other.path(), None).expect("there is a GPU").contains("renderD128 is a GPU"));
    }
}

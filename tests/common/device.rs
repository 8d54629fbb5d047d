//! The device of the tests: a software driver, chosen explicitly. A test without one fails; it is never skipped.

use std::sync::OnceLock;

use gpu_rt::gpu::device::{Adapters, Device};

/// The software device, opened once for a test program.
pub fn software() -> &'static Device {
    static DEVICE: OnceLock<Device> = OnceLock::new();
    DEVICE.get_or_init(open)
}

/// The software driver, opened anew: with nothing compiled for it yet.
pub fn open() -> Device {
    let adapters = Adapters::find();
    let index = index_among(&adapters);
    let adapter = adapters.choose(Some(&index)).expect("the adapter is listed");
    Device::open(adapter).expect("the software device opens")
}

/// The device as the program takes it: `--device INDEX`.
pub fn index() -> &'static str {
    static INDEX: OnceLock<String> = OnceLock::new();
    INDEX.get_or_init(|| index_among(&Adapters::find()))
}

fn index_among(adapters: &Adapters) -> String {
    let index = match std::env::var("GPU_RT_TEST_DEVICE") {
        // Another device, by index or name, for running the suite on a GPU.
        Ok(name) => adapters.index_of_choice(Some(&name)).expect("GPU_RT_TEST_DEVICE names no device"),
        Err(_) => adapters
            .names()
            .iter()
            .position(|(name, _)| name.software)
            .expect("the tests need a software Vulkan driver: apt-get install mesa-vulkan-drivers"),
    };
    index.to_string()
}

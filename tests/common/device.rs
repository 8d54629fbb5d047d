//! The device of the tests: a software driver, chosen explicitly. A test without one fails; it is never skipped.

use std::sync::{Arc, Mutex, OnceLock};

use gpu_rt::gpu::device::{Adapters, Device};

/// The software device of this test. Tests that run at the same time have devices of their own: a software device compiles in the one
/// thread of its queue, and the renders of all others would wait. A later test takes the device of one that has ended, with its kernels.
pub fn software() -> &'static Arc<Device> {
    thread_local! {
        static LENT: Lent = {
            let free = FREE.lock().expect("no test fails here").pop();
            Lent(free.unwrap_or_else(|| Box::leak(Box::new(Arc::new(open())))))
        };
    }
    LENT.with(|lent| lent.0)
}

/// Devices that no test has.
static FREE: Mutex<Vec<&'static Arc<Device>>> = Mutex::new(Vec::new());

/// A device for as long as a thread lives.
struct Lent(&'static Arc<Device>);

impl Drop for Lent {
    fn drop(&mut self) {
        FREE.lock().expect("no test fails here").push(self.0);
    }
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

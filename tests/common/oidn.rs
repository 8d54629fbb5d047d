//! Open Image Denoise: the real library, which `make oidn` fetches, and one that fails.

use std::path::PathBuf;

/// The folder of the real library. Without it the tests fail: none is skipped.
pub fn folder() -> PathBuf {
    let fetched = || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/target/oidn/pyoidn/oidn/lib"));
    let folder = std::env::var_os("OIDN_DIR").map_or_else(fetched, PathBuf::from);
    assert!(folder.is_dir(), "{} is not there: `make oidn` fetches Open Image Denoise", folder.display());
    folder
}

/// A folder with a library of its name that fails as `GPU_RT_DENOISER` says ([`tests/layer/denoiser.rs`](../layer/denoiser.rs)).
#[cfg(target_os = "linux")]
pub fn failing(into: &std::path::Path) {
    let library = super::fault::library("denoiser");
    std::fs::copy(library, into.join("libOpenImageDenoise.so.2")).expect("the library is copied");
}

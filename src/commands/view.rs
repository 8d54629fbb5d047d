//! `gpu-rt view`: a scene in a window, to look around in.

mod args;
#[cfg(feature = "window")]
mod window;

pub use args::WindowArgs;
#[cfg(feature = "window")]
pub use window::{Link, Rendering, ViewState, Window, run};

/// Refuses: this program has no window.
///
/// # Errors
/// `Error::Usage`, which says how to build one that has it.
#[cfg(not(feature = "window"))]
pub fn run(_: &WindowArgs) -> crate::error::Result<()> {
    Err(crate::error::Error::Usage(
        "this program is built without a window: `cargo build --release --features window` builds one with it, and releases have it. `gpu-rt \
         render --preview` draws in the terminal"
            .to_owned(),
    ))
}

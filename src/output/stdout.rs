//! Whether standard output is closed (`gpu-rt … >&-`). Rust's library opens /dev/null in its place before `main`, so that every write would
//! succeed, and an image or a report be lost. What the loader runs before that can tell.

use std::io;

/// An error if standard output was closed when the program began.
pub fn check() -> io::Result<()> {
    match at_start::is_closed() {
        true => Err(io::Error::other("it is closed")),
        false => Ok(()),
    }
}

#[cfg(unix)]
mod at_start {
    use std::sync::atomic::{AtomicBool, Ordering};

    static IS_CLOSED: AtomicBool = AtomicBool::new(false);

    // SAFETY: these sections are lists of functions that the loader calls.
    #[used]
    #[cfg_attr(target_vendor = "apple", unsafe(link_section = "__DATA,__mod_init_func"))]
    #[cfg_attr(not(target_vendor = "apple"), unsafe(link_section = ".init_array"))]
    static BEFORE_MAIN: extern "C" fn() = look;

    extern "C" fn look() {
        // SAFETY: it reads the flags of a descriptor, and fails if that is not open.
        let is_closed = unsafe { libc::fcntl(libc::STDOUT_FILENO, libc::F_GETFD) } == -1;
        IS_CLOSED.store(is_closed, Ordering::Relaxed);
    }

    pub fn is_closed() -> bool {
        IS_CLOSED.load(Ordering::Relaxed)
    }
}

#[cfg(not(unix))]
mod at_start {
    pub fn is_closed() -> bool {
        false
    }
}

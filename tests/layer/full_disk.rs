//! A disk that is full. `LD_PRELOAD`ed, it has no room for what is written to the files of the folder `GPU_RT_DISK`, as long as the file
//! `GPU_RT_DISK_IS_FULL` exists.

use std::ffi::{c_int, c_void};
use std::mem::transmute;
use std::path::Path;

type Write = unsafe extern "C" fn(c_int, *const c_void, usize) -> isize;

/// ENOSPC of Linux.
const NO_SPACE: c_int = 28;
/// RTLD_NEXT of Linux.
const NEXT: *mut c_void = -1isize as *mut c_void;

unsafe extern "C" {
    fn dlsym(library: *mut c_void, name: *const std::ffi::c_char) -> *mut c_void;
    fn __errno_location() -> *mut c_int;
}

/// # Safety
/// That of write.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn write(file: c_int, bytes: *const c_void, count: usize) -> isize {
    let is_full = std::env::var_os("GPU_RT_DISK_IS_FULL").is_some_and(|mark| Path::new(&mark).exists());
    let is_there = || {
        let path = std::fs::read_link(format!("/proc/self/fd/{file}")).ok();
        path.zip(std::env::var_os("GPU_RT_DISK")).is_some_and(|(path, disk)| path.starts_with(disk))
    };
    unsafe {
        if is_full && is_there() {
            *__errno_location() = NO_SPACE;
            return -1;
        }
        let write: Write = transmute(dlsym(NEXT, c"write".as_ptr()));
        write(file, bytes, count)
    }
}

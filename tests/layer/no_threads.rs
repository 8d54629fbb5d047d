//! A system that has no thread for the program, but for its driver. `LD_PRELOAD`ed, it refuses the threads that start in a program
//! instead of a library. A refusal leaves the file `GPU_RT_FAULT_MARK`.

use std::ffi::{CStr, c_char, c_int, c_void};
use std::mem::transmute;

type Start = unsafe extern "C" fn(*mut c_void) -> *mut c_void;
type Create = unsafe extern "C" fn(*mut c_void, *const c_void, Start, *mut c_void) -> c_int;

const TRY_AGAIN: c_int = 11;

/// Dl_info of Linux.
#[repr(C)]
struct SymbolInfo {
    file: *const c_char,
    base: *const c_void,
    symbol: *const c_char,
    address: *const c_void,
}

unsafe extern "C" {
    fn dlsym(library: *mut c_void, name: *const c_char) -> *mut c_void;
    fn dladdr(address: *const c_void, info: *mut SymbolInfo) -> c_int;
}

/// RTLD_NEXT of Linux.
const NEXT: *mut c_void = -1isize as *mut c_void;

/// # Safety
/// That of pthread_create.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pthread_create(
    thread: *mut c_void,
    attributes: *const c_void,
    start: Start,
    argument: *mut c_void,
) -> c_int {
    unsafe {
        let mut info: SymbolInfo = std::mem::zeroed();
        dladdr(start as *const c_void, &mut info);
        let in_library = !info.file.is_null() && CStr::from_ptr(info.file).to_string_lossy().contains(".so");
        if !in_library {
            if let Some(mark) = std::env::var_os("GPU_RT_FAULT_MARK") {
                let _ = std::fs::write(mark, "");
            }
            return TRY_AGAIN;
        }
        let create: Create = transmute(dlsym(NEXT, c"pthread_create".as_ptr()));
        create(thread, attributes, start, argument)
    }
}

//! A library with the functions of Open Image Denoise that `gpu-rt denoise` calls. It denoises nothing, and fails as `GPU_RT_DENOISER` says:
//! `old` and `new` are other versions, `no_device`, `memory` and `silent` errors, `nan` a result that is none. Otherwise its output is 1.

use std::ffi::{CStr, c_char, c_int, c_void};
use std::sync::Mutex;

type Handle = *mut c_void;

/// Where the output goes, and how many floats it has.
static OUTPUT: Mutex<(usize, usize)> = Mutex::new((0, 0));

fn fails(how: &str) -> bool {
    std::env::var("GPU_RT_DENOISER").is_ok_and(|value| value == how)
}

fn some() -> Handle {
    std::ptr::dangling_mut::<u8>().cast()
}

#[unsafe(no_mangle)]
extern "C" fn oidnNewDevice(_: c_int) -> Handle {
    if fails("no_device") { std::ptr::null_mut() } else { some() }
}

#[unsafe(no_mangle)]
extern "C" fn oidnCommitDevice(_: Handle) {}

#[unsafe(no_mangle)]
extern "C" fn oidnReleaseDevice(_: Handle) {}

/// # Safety
/// The name ends with a zero byte.
#[unsafe(no_mangle)]
unsafe extern "C" fn oidnGetDeviceInt(_: Handle, name: *const c_char) -> c_int {
    match unsafe { CStr::from_ptr(name) }.to_bytes() {
        b"versionMajor" if fails("old") => 1,
        b"versionMajor" if fails("new") => 3,
        b"versionMajor" => 2,
        _ => 0,
    }
}

/// # Safety
/// The message can be written to.
#[unsafe(no_mangle)]
unsafe extern "C" fn oidnGetDeviceError(device: Handle, message: *mut *const c_char) -> c_int {
    let (code, words) = match () {
        () if device.is_null() => (5, c"unsupported hardware"),
        () if fails("memory") && OUTPUT.lock().unwrap().1 > 0 => (4, c"out of memory"),
        () if fails("silent") && OUTPUT.lock().unwrap().1 > 0 => return 1,
        () => return 0,
    };
    unsafe { *message = words.as_ptr() };
    code
}

#[unsafe(no_mangle)]
extern "C" fn oidnNewFilter(_: Handle, _: *const c_char) -> Handle {
    some()
}

#[unsafe(no_mangle)]
extern "C" fn oidnReleaseFilter(_: Handle) {}

/// # Safety
/// The name ends with a zero byte.
#[unsafe(no_mangle)]
unsafe extern "C" fn oidnSetSharedFilterImage(
    _: Handle,
    name: *const c_char,
    data: *mut c_void,
    _: c_int,
    width: usize,
    height: usize,
    _: usize,
    _: usize,
    _: usize,
) {
    if unsafe { CStr::from_ptr(name) } == c"output" {
        *OUTPUT.lock().unwrap() = (data as usize, 3 * width * height);
    }
}

#[unsafe(no_mangle)]
extern "C" fn oidnSetFilterBool(_: Handle, _: *const c_char, _: bool) {}

#[unsafe(no_mangle)]
extern "C" fn oidnCommitFilter(_: Handle) {}

/// # Safety
/// The output is there.
#[unsafe(no_mangle)]
unsafe extern "C" fn oidnExecuteFilter(_: Handle) {
    let (data, count) = *OUTPUT.lock().unwrap();
    let value = if fails("nan") { f32::NAN } else { 1.0 };
    unsafe { std::slice::from_raw_parts_mut(data as *mut f32, count) }.fill(value);
}

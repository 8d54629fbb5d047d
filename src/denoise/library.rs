//! Open Image Denoise by its C interface (oidn.h of version 2), loaded at run time. All unsafe code of denoising is here.

use std::ffi::{CStr, OsStr, c_char, c_int, c_void};
use std::mem::ManuallyDrop;
use std::ptr;

use libloading::Library as Loaded;

use crate::data::Rgb;

/// The version of the interface. The versions 2.x share it.
pub const MAJOR: i32 = 2;
/// The name of the library's file.
pub const FILE: &str = if cfg!(target_os = "windows") {
    "OpenImageDenoise.dll"
} else if cfg!(target_os = "macos") {
    "libOpenImageDenoise.2.dylib"
} else {
    "libOpenImageDenoise.so.2"
};

/// `OIDNDevice` and `OIDNFilter`: pointers to what only the library knows.
type Handle = *mut c_void;

/// `OIDN_DEVICE_TYPE_CPU`, `OIDN_FORMAT_FLOAT3` and `OIDN_ERROR_NONE`.
const CPU: c_int = 1;
const FLOAT3: c_int = 3;
const NO_ERROR: c_int = 0;

/// The functions that are called, with the types of oidn.h.
struct Functions {
    new_device: unsafe extern "C" fn(c_int) -> Handle,
    commit_device: unsafe extern "C" fn(Handle),
    release_device: unsafe extern "C" fn(Handle),
    device_int: unsafe extern "C" fn(Handle, *const c_char) -> c_int,
    device_error: unsafe extern "C" fn(Handle, *mut *const c_char) -> c_int,
    new_filter: unsafe extern "C" fn(Handle, *const c_char) -> Handle,
    release_filter: unsafe extern "C" fn(Handle),
    set_image: unsafe extern "C" fn(Handle, *const c_char, *mut c_void, c_int, usize, usize, usize, usize, usize),
    set_bool: unsafe extern "C" fn(Handle, *const c_char, bool),
    commit_filter: unsafe extern "C" fn(Handle),
    execute_filter: unsafe extern "C" fn(Handle),
}

impl Functions {
    /// Finds them in a library.
    ///
    /// # Safety
    /// If the library has functions of these names, they must be those of Open Image Denoise 2.
    unsafe fn load(library: &Loaded) -> Result<Functions, String> {
        // SAFETY: that the types fit is what the caller promises. `symbol` copies the pointers, which are valid as long as the library is loaded.
        unsafe fn symbol<T: Copy>(library: &Loaded, name: &CStr) -> Result<T, String> {
            let found = unsafe { library.get::<T>(name.to_bytes_with_nul()) };
            let name = name.to_string_lossy();
            found.map(|function| *function).map_err(|_| format!("it has no function {name}"))
        }
        // SAFETY: as above.
        unsafe {
            Ok(Functions {
                new_device: symbol(library, c"oidnNewDevice")?,
                commit_device: symbol(library, c"oidnCommitDevice")?,
                release_device: symbol(library, c"oidnReleaseDevice")?,
                device_int: symbol(library, c"oidnGetDeviceInt")?,
                device_error: symbol(library, c"oidnGetDeviceError")?,
                new_filter: symbol(library, c"oidnNewFilter")?,
                release_filter: symbol(library, c"oidnReleaseFilter")?,
                set_image: symbol(library, c"oidnSetSharedFilterImage")?,
                set_bool: symbol(library, c"oidnSetFilterBool")?,
                commit_filter: symbol(library, c"oidnCommitFilter")?,
                execute_filter: symbol(library, c"oidnExecuteFilter")?,
            })
        }
    }
}

/// The library with one of its devices: the processor.
pub struct Library {
    functions: Functions,
    device: Handle,
    /// The version, such as 2.5.1.
    pub version: String,
}

impl Library {
    /// Loads the file at a path, or of a name by the system's rules. The error is a reason in words.
    pub fn load(file: &OsStr) -> Result<Library, String> {
        let not_usable = |reason| format!("it cannot be used as Open Image Denoise {MAJOR}: {reason}");
        // SAFETY: loading a library runs its code, so it has to be the library that its name says. The user installed it, or names its folder.
        let library =
            unsafe { Loaded::new(file) }.map_err(|error| format!("it cannot be loaded: {}", reason(&error)))?;
        // The library is never unloaded: its threads outlive its devices, and its functions stay valid.
        let library = ManuallyDrop::new(library);
        // SAFETY: a library with all of these functions is Open Image Denoise. Those of version 1 lack some of them.
        let functions = unsafe { Functions::load(&library) }.map_err(not_usable)?;
        // SAFETY: the number is one of OIDNDeviceType. The device may be null.
        let device = unsafe { (functions.new_device)(CPU) };
        if device.is_null() {
            return Err(not_usable(error_of(&functions, device)));
        }
        // SAFETY: the device is not null, and the names end with a zero byte.
        let number = |name: &CStr| unsafe { (functions.device_int)(device, name.as_ptr()) };
        let version = [c"versionMajor", c"versionMinor", c"versionPatch"].map(number);
        let [major, minor, patch] = version;
        // From here on, every return releases the device.
        let library = Library { functions, device, version: format!("{major}.{minor}.{patch}") };
        if major != MAJOR {
            return Err(not_usable(format!("it has version {}, expected {MAJOR}", library.version)));
        }
        // SAFETY: the device is not null.
        unsafe { (library.functions.commit_device)(library.device) };
        library.check().map_err(not_usable).map(|()| library)
    }

    /// Runs the filter for ray tracing: the images by their names, all of one size, and the parameters that are true. The error is a reason
    /// in words.
    pub fn filter(
        &self,
        (width, height): (usize, usize),
        images: &[(&CStr, &[Rgb<f32>])],
        parameters: &[&CStr],
    ) -> Result<Vec<Rgb<f32>>, String> {
        let pixels = width.saturating_mul(height);
        if images.iter().any(|(_, image)| image.len() != pixels) {
            return Err("its images differ in size".to_string());
        }
        let mut output: Vec<Rgb<f32>> = Vec::new();
        output.try_reserve_exact(pixels).map_err(|error| error.to_string())?;
        output.resize(pixels, [0.0; 3]);
        let Functions { new_filter, release_filter, set_image, set_bool, commit_filter, execute_filter, .. } =
            self.functions;
        // SAFETY: the device is not null, and the name ends with a zero byte.
        let filter = unsafe { new_filter(self.device, c"RT".as_ptr()) };
        if filter.is_null() {
            return Err(error_of(&self.functions, self.device));
        }
        let set = |name: &CStr, data: *mut c_void| {
            // SAFETY: the filter is not null. `data` has width x height times three floats without gaps, which is what the zeros say.
            unsafe { set_image(filter, name.as_ptr(), data, FLOAT3, width, height, 0, 0, 0) };
        };
        for (name, image) in images {
            // The library does not write to images other than the output.
            set(name, image.as_ptr().cast_mut().cast());
        }
        set(c"output", output.as_mut_ptr().cast());
        for name in parameters {
            // SAFETY: the filter is not null, and the name ends with a zero byte.
            unsafe { set_bool(filter, name.as_ptr(), true) };
        }
        // SAFETY: the filter is not null, and its images live until the end of this function. Executing returns when the output is written.
        unsafe {
            commit_filter(filter);
            execute_filter(filter);
            release_filter(filter);
        }
        self.check().map(|()| output)
    }

    fn check(&self) -> Result<(), String> {
        error(&self.functions, self.device).map_or(Ok(()), Err)
    }
}

impl Drop for Library {
    fn drop(&mut self) {
        // SAFETY: the device is not null, and nothing refers to it any more.
        unsafe { (self.functions.release_device)(self.device) };
    }
}

/// The error of a device, or of its creation if it is null.
fn error(functions: &Functions, device: Handle) -> Option<String> {
    let mut message = ptr::null();
    // SAFETY: a null device is allowed here, and `message` can be written to.
    let code = unsafe { (functions.device_error)(device, &mut message) };
    if code == NO_ERROR {
        return None;
    }
    if message.is_null() {
        return Some(format!("error {code}"));
    }
    // SAFETY: the message ends with a zero byte, and lives until this thread asks the library for the next error.
    Some(unsafe { CStr::from_ptr(message) }.to_string_lossy().into_owned())
}

/// The error that a call that failed has left.
fn error_of(functions: &Functions, device: Handle) -> String {
    error(functions, device).unwrap_or_else(|| "it does not say why".to_string())
}

/// The message of the system, without the words of the crate around it.
fn reason(error: &libloading::Error) -> String {
    use std::error::Error;
    error.source().map_or_else(|| error.to_string(), ToString::to_string)
}

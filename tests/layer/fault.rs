//! A Vulkan layer that makes a driver fail. The tests build it and put it between the program and the driver
//! (tests/common/fault.rs).
//!
//! `GPU_RT_FAULT` says what fails: `FUNCTION:CALL:RESULT:HOW_OFTEN`. The calls of a function count from 1. The result is `lost`
//! (VK_ERROR_DEVICE_LOST), `memory` (VK_ERROR_OUT_OF_DEVICE_MEMORY), `hang`: from then on the device finishes nothing, or `skip`: the device
//! reports work as done that it has not done. `skip` of `vkQueueSubmit` leaves out all commands, `half` all but the first command buffer,
//! and `skip` of `vkCmdDispatch` leaves out that dispatch. It happens
//! `once` or `always`: in this call, or in this and all later ones. With `GPU_RT_FAULT_AFTER`, calls count once that file exists. A
//! fault that has happened leaves the file `GPU_RT_FAULT_MARK`.
//!
//! With `GPU_RT_FENCES` the driver has no timeline semaphores, so that wgpu waits for fences. With `GPU_RT_TWINS` it has each
//! physical device twice. With `GPU_RT_ROUGH` (`up` or `down`) it makes quotients and roots too large or too small, as much as WGSL allows.

#![allow(non_snake_case)]

use std::ffi::{CStr, c_char, c_void};
use std::mem::transmute;
use std::path::Path;
use std::ptr::null_mut;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicPtr, AtomicU64, Ordering};

mod rough;

type Handle = *mut c_void;
type Any = *mut c_void;
type Function = *const c_void;
type GetProcAddr = unsafe extern "system" fn(Handle, *const c_char) -> Function;

const SUCCESS: i32 = 0;
const NOT_READY: i32 = 1;
const TIMEOUT: i32 = 2;
const OUT_OF_DEVICE_MEMORY: i32 = -2;
const INITIALIZATION_FAILED: i32 = -3;
const DEVICE_LOST: i32 = -4;
// No results of Vulkan: what to leave out.
const SKIP: i32 = i32::MIN;
const HALF: i32 = i32::MIN + 1;

// The structs by which the loader links layers (vulkan/vk_layer.h).

#[repr(C)]
pub struct Negotiation {
    struct_type: i32,
    next: Any,
    version: u32,
    get_instance_proc_addr: GetProcAddr,
    get_device_proc_addr: GetProcAddr,
    get_physical_device_proc_addr: Function,
}

/// The beginning of VkLayerInstanceCreateInfo and VkLayerDeviceCreateInfo.
#[repr(C)]
struct LinkInfo {
    struct_type: i32,
    next: *mut LinkInfo,
    function: i32,
    link: *mut Link,
}

/// VkLayerInstanceLink and VkLayerDeviceLink. Of an instance, the second function is of no use here.
#[repr(C)]
struct Link {
    next: *mut Link,
    get_instance_proc_addr: GetProcAddr,
    get_device_proc_addr: GetProcAddr,
}

const INSTANCE_LINK: i32 = 47;
const DEVICE_LINK: i32 = 48;

/// The beginning of every struct that is chained.
#[repr(C)]
struct Chained {
    struct_type: i32,
    next: *mut Chained,
    /// Of VkPhysicalDeviceTimelineSemaphoreFeatures: whether it has them.
    flag: u32,
}

const TIMELINE_SEMAPHORE_FEATURES: i32 = 1_000_207_000;

// The functions of the next layer, or of the driver. The program has one instance at a time. The loader gives those of an instance
// only while it creates it; later it would give this layer's own.

static INSTANCE: AtomicPtr<c_void> = AtomicPtr::new(null_mut());
static NEXT_INSTANCE_PROC: AtomicPtr<c_void> = AtomicPtr::new(null_mut());
static NEXT_DEVICE_PROC: AtomicPtr<c_void> = AtomicPtr::new(null_mut());
static NEXT_FEATURES: AtomicPtr<c_void> = AtomicPtr::new(null_mut());
static NEXT_PHYSICAL_DEVICES: AtomicPtr<c_void> = AtomicPtr::new(null_mut());

unsafe fn next_of_instance(instance: Handle, name: *const c_char) -> Function {
    let next = NEXT_INSTANCE_PROC.load(Ordering::Relaxed);
    unsafe { transmute::<Any, GetProcAddr>(next)(instance, name) }
}

unsafe fn next_of_device(device: Handle, name: *const c_char) -> Function {
    let next = NEXT_DEVICE_PROC.load(Ordering::Relaxed);
    unsafe { transmute::<Any, GetProcAddr>(next)(device, name) }
}

// The fault.

struct Fault {
    function: String,
    call: u64,
    result: String,
    always: bool,
    calls: AtomicU64,
}

/// Whether the device finishes nothing any more.
static HANGS: AtomicBool = AtomicBool::new(false);
/// The last value of the semaphore by which wgpu counts submissions; it has only one.
static COUNTED: AtomicU64 = AtomicU64::new(0);
/// The submissions so far: the value that the semaphore will have.
static SUBMITTED: AtomicU64 = AtomicU64::new(0);

fn fault() -> Option<&'static Fault> {
    static FAULT: OnceLock<Option<Fault>> = OnceLock::new();
    let read = || {
        let text = std::env::var("GPU_RT_FAULT").ok()?;
        let [function, call, result, how_often] = text.split(':').collect::<Vec<_>>()[..] else { return None };
        Some(Fault {
            function: function.to_string(),
            call: call.parse().ok()?,
            result: result.to_string(),
            always: how_often == "always",
            calls: AtomicU64::new(0),
        })
    };
    FAULT.get_or_init(read).as_ref()
}

/// Counts a call, and returns what it is to return instead of doing its work.
fn failing(name: &str) -> Option<i32> {
    let fault = fault().filter(|fault| fault.function == name)?;
    if std::env::var_os("GPU_RT_FAULT_AFTER").is_some_and(|file| !Path::new(&file).exists()) {
        return None;
    }
    let call = fault.calls.fetch_add(1, Ordering::Relaxed) + 1;
    if call < fault.call || (call > fault.call && !fault.always) {
        return None;
    }
    if let Some(mark) = std::env::var_os("GPU_RT_FAULT_MARK") {
        let _ = std::fs::write(mark, name);
    }
    match fault.result.as_str() {
        "lost" => Some(DEVICE_LOST),
        "memory" => Some(OUT_OF_DEVICE_MEMORY),
        "skip" => Some(SKIP),
        "half" => Some(HALF),
        _ => {
            HANGS.store(true, Ordering::Relaxed);
            None
        }
    }
}

/// What a function does on a device that hangs; none where it does its work. A wait returns at once that its time is over, so
/// that no test has to wait.
fn hanging(name: &str) -> Option<i32> {
    if name == "vkQueueSubmit" {
        SUBMITTED.fetch_add(1, Ordering::Relaxed);
    }
    if !HANGS.load(Ordering::Relaxed) {
        return None;
    }
    match name {
        "vkWaitSemaphores" | "vkWaitForFences" => Some(TIMEOUT),
        "vkGetFenceStatus" => Some(NOT_READY),
        // A device that was idle when it began to hang stays so.
        "vkQueueWaitIdle" | "vkDeviceWaitIdle" if SUBMITTED.load(Ordering::Relaxed) > COUNTED.load(Ordering::Relaxed) => loop {
            std::thread::park();
        },
        _ => None,
    }
}

/// Functions of a device that can fail: each asks first whether it is to, and then calls the function of the driver.
macro_rules! can_fail {
    ($($name:ident($($argument:ident: $kind:ty),*))*) => {
        $(
            unsafe extern "system" fn $name(device: Handle, $($argument: $kind),*) -> i32 {
                let name = stringify!($name);
                if let Some(result) = failing(name).or_else(|| hanging(name)) {
                    return result;
                }
                let next = next::$name.load(Ordering::Relaxed);
                let next: unsafe extern "system" fn(Handle, $($kind),*) -> i32 = unsafe { transmute(next) };
                unsafe { next(device, $($argument),*) }
            }
        )*

        #[allow(non_upper_case_globals)]
        mod next {
            use super::*;
            $(pub static $name: AtomicPtr<c_void> = AtomicPtr::new(null_mut());)*
        }

        /// This layer's function of the name, if it has one and the driver too.
        fn of_device(name: &str, next: Function) -> Option<Function> {
            match name {
                _ if next.is_null() => None,
                $(
                    stringify!($name) => {
                        next::$name.store(next.cast_mut(), Ordering::Relaxed);
                        Some($name as Function)
                    }
                )*
                _ => None,
            }
        }
    };
}

can_fail! {
    vkWaitForFences(count: u32, fences: Any, all: u32, timeout: u64)
    vkWaitSemaphores(info: Any, timeout: u64)
    vkGetFenceStatus(fence: u64)
    vkQueueSubmit(count: u32, submits: Any, fence: u64)
    vkQueueWaitIdle()
    vkDeviceWaitIdle()
    vkAllocateMemory(info: Any, allocator: Any, memory: Any)
    vkMapMemory(memory: u64, offset: u64, size: u64, flags: u32, data: Any)
    vkCreateComputePipelines(cache: u64, count: u32, infos: Any, allocator: Any, pipelines: Any)
    vkCreateBuffer(info: Any, allocator: Any, buffer: Any)
    vkBindBufferMemory(buffer: u64, memory: u64, offset: u64)
    vkCreateShaderModule(info: Any, allocator: Any, module: Any)
    vkCreatePipelineLayout(info: Any, allocator: Any, layout: Any)
    vkCreateDescriptorSetLayout(info: Any, allocator: Any, layout: Any)
    vkCreateDescriptorPool(info: Any, allocator: Any, pool: Any)
    vkAllocateDescriptorSets(info: Any, sets: Any)
    vkCreateCommandPool(info: Any, allocator: Any, pool: Any)
    vkAllocateCommandBuffers(info: Any, buffers: Any)
    vkBeginCommandBuffer(info: Any)
    vkEndCommandBuffer()
    vkCreateSemaphore(info: Any, allocator: Any, semaphore: Any)
    vkCreateFence(info: Any, allocator: Any, fence: Any)
    vkResetFences(count: u32, fences: Any)
    vkCreateQueryPool(info: Any, allocator: Any, pool: Any)
    vkGetSemaphoreCounterValue(semaphore: u64, value: *mut u64)
    vkCmdDispatch(x: u32, y: u32, z: u32)
}

/// VkSubmitInfo.
#[repr(C)]
#[derive(Clone, Copy)]
struct SubmitInfo {
    struct_type: i32,
    next: Any,
    wait_semaphores: u32,
    waits: Any,
    wait_stages: Any,
    command_buffers: u32,
    commands: Any,
    signal_semaphores: u32,
    signals: Any,
}

/// Submits what a fault leaves of the commands, and says that all of them are done.
unsafe extern "system" fn queue_submit(queue: Handle, count: u32, submits: *mut SubmitInfo, fence: u64) -> i32 {
    let most = match failing("vkQueueSubmit") {
        Some(SKIP) => 0,
        Some(HALF) => 1,
        Some(result) => return result,
        None => u32::MAX,
    };
    hanging("vkQueueSubmit");
    let mut left = Vec::new();
    for index in 0..count as usize {
        let submit = unsafe { *submits.add(index) };
        left.push(SubmitInfo { command_buffers: submit.command_buffers.min(most), ..submit });
    }
    let next = next::vkQueueSubmit.load(Ordering::Relaxed);
    let next: unsafe extern "system" fn(Handle, u32, *mut SubmitInfo, u64) -> i32 = unsafe { transmute(next) };
    unsafe { next(queue, count, left.as_mut_ptr(), fence) }
}

/// Keeps the counter of a device that hangs at its last value.
unsafe extern "system" fn counter_value(device: Handle, semaphore: u64, value: *mut u64) -> i32 {
    if HANGS.load(Ordering::Relaxed) {
        unsafe { *value = COUNTED.load(Ordering::Relaxed) };
        return SUCCESS;
    }
    let result = unsafe { vkGetSemaphoreCounterValue(device, semaphore, value) };
    if result == SUCCESS {
        COUNTED.store(unsafe { *value }, Ordering::Relaxed);
    }
    result
}

/// VkShaderModuleCreateInfo.
#[repr(C)]
#[derive(Clone, Copy)]
struct ModuleInfo {
    struct_type: i32,
    next: Any,
    flags: u32,
    bytes: usize,
    words: *const u32,
}

/// Makes a module with rough quotients, if they are asked for.
unsafe extern "system" fn create_shader_module(
    device: Handle,
    info: *mut ModuleInfo,
    allocator: Any,
    module: Any,
) -> i32 {
    let factor = match std::env::var("GPU_RT_ROUGH").as_deref() {
        Ok("up") => 1f32.next_up(),
        Ok("down") => 1f32.next_down(),
        _ => return unsafe { vkCreateShaderModule(device, info.cast(), allocator, module) },
    };
    let info = unsafe { *info };
    let words = unsafe { std::slice::from_raw_parts(info.words, info.bytes / 4) };
    let words = rough::with_rough_quotients(words, factor);
    let mut info = ModuleInfo { bytes: 4 * words.len(), words: words.as_ptr(), ..info };
    unsafe { vkCreateShaderModule(device, (&raw mut info).cast(), allocator, module) }
}

// What the loader calls.

/// The link to the next layer, which this one takes out of the chain.
unsafe fn take_link(create_info: *mut LinkInfo, struct_type: i32) -> Option<&'static Link> {
    unsafe {
        let mut info = (*create_info).next;
        while !info.is_null() && !((*info).struct_type == struct_type && (*info).function == 0) {
            info = (*info).next;
        }
        let link = info.as_ref()?.link.as_ref()?;
        (*info).link = link.next;
        Some(link)
    }
}

type Create = unsafe extern "system" fn(Handle, *mut LinkInfo, Any, *mut Handle) -> i32;

unsafe extern "system" fn create_instance(info: *mut LinkInfo, allocator: Any, instance: *mut Handle) -> i32 {
    unsafe {
        let Some(link) = take_link(info, INSTANCE_LINK) else { return INITIALIZATION_FAILED };
        NEXT_INSTANCE_PROC.store(link.get_instance_proc_addr as Any, Ordering::Relaxed);
        let create = next_of_instance(null_mut(), c"vkCreateInstance".as_ptr());
        let create: unsafe extern "system" fn(*mut LinkInfo, Any, *mut Handle) -> i32 = transmute(create);
        let result = create(info, allocator, instance);
        if result == SUCCESS {
            let next = |name: &CStr| next_of_instance(*instance, name.as_ptr()).cast_mut();
            INSTANCE.store(*instance, Ordering::Relaxed);
            NEXT_FEATURES.store(next(c"vkGetPhysicalDeviceFeatures2"), Ordering::Relaxed);
            NEXT_PHYSICAL_DEVICES.store(next(c"vkEnumeratePhysicalDevices"), Ordering::Relaxed);
        }
        result
    }
}

unsafe extern "system" fn create_device(
    physical: Handle,
    info: *mut LinkInfo,
    allocator: Any,
    device: *mut Handle,
) -> i32 {
    if let Some(result) = failing("vkCreateDevice") {
        return result;
    }
    unsafe {
        let Some(link) = take_link(info, DEVICE_LINK) else { return INITIALIZATION_FAILED };
        COUNTED.store(0, Ordering::Relaxed);
        SUBMITTED.store(0, Ordering::Relaxed);
        NEXT_DEVICE_PROC.store(link.get_device_proc_addr as Any, Ordering::Relaxed);
        let instance = INSTANCE.load(Ordering::Relaxed);
        let create: Create = transmute((link.get_instance_proc_addr)(instance, c"vkCreateDevice".as_ptr()));
        create(physical, info, allocator, device)
    }
}

unsafe extern "system" fn features(physical: Handle, features: *mut Chained) {
    unsafe {
        let next = NEXT_FEATURES.load(Ordering::Relaxed);
        let next: unsafe extern "system" fn(Handle, *mut Chained) = transmute(next);
        next(physical, features);
        let mut chained = (*features).next;
        while let Some(found) = chained.as_mut() {
            if found.struct_type == TIMELINE_SEMAPHORE_FEATURES {
                found.flag = 0;
            }
            chained = found.next;
        }
    }
}

unsafe extern "system" fn physical_devices(instance: Handle, count: *mut u32, devices: *mut Handle) -> i32 {
    unsafe {
        let next = NEXT_PHYSICAL_DEVICES.load(Ordering::Relaxed);
        let next: unsafe extern "system" fn(Handle, *mut u32, *mut Handle) -> i32 = transmute(next);
        if !devices.is_null() {
            *count /= 2;
        }
        let result = next(instance, count, devices);
        if !devices.is_null() {
            let found = *count as usize;
            std::ptr::copy_nonoverlapping(devices, devices.add(found), found);
        }
        *count *= 2;
        result
    }
}

unsafe extern "system" fn instance_proc(instance: Handle, name: *const c_char) -> Function {
    let text = unsafe { CStr::from_ptr(name) }.to_str().unwrap_or_default();
    let has = |variable: &str| std::env::var_os(variable).is_some();
    match text {
        "vkGetInstanceProcAddr" => instance_proc as Function,
        "vkCreateInstance" => create_instance as Function,
        "vkCreateDevice" => create_device as Function,
        "vkGetPhysicalDeviceFeatures2" | "vkGetPhysicalDeviceFeatures2KHR" if has("GPU_RT_FENCES") => {
            features as Function
        }
        "vkEnumeratePhysicalDevices" if has("GPU_RT_TWINS") => physical_devices as Function,
        "vkGetDeviceProcAddr" => device_proc as Function,
        _ => unsafe { next_of_instance(instance, name) },
    }
}

unsafe extern "system" fn device_proc(device: Handle, name: *const c_char) -> Function {
    let text = unsafe { CStr::from_ptr(name) }.to_str().unwrap_or_default();
    if text == "vkGetDeviceProcAddr" {
        return device_proc as Function;
    }
    let next = unsafe { next_of_device(device, name) };
    // wgpu names some functions as their extensions do.
    let core = text.strip_suffix("KHR").unwrap_or(text);
    match of_device(core, next) {
        Some(_) if core == "vkGetSemaphoreCounterValue" => counter_value as Function,
        Some(_) if core == "vkQueueSubmit" => queue_submit as Function,
        Some(_) if core == "vkCreateShaderModule" => create_shader_module as Function,
        Some(function) => function,
        None => next,
    }
}

/// The first function that the loader calls.
///
/// # Safety
/// The loader passes a valid pointer.
#[unsafe(no_mangle)]
pub unsafe extern "system" fn vkNegotiateLoaderLayerInterfaceVersion(negotiation: *mut Negotiation) -> i32 {
    let negotiation = unsafe { &mut *negotiation };
    negotiation.version = negotiation.version.min(2);
    negotiation.get_instance_proc_addr = instance_proc;
    negotiation.get_device_proc_addr = device_proc;
    negotiation.get_physical_device_proc_addr = std::ptr::null();
    SUCCESS
}

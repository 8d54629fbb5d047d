//! Panics of wgpu, as errors.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

thread_local! {
    /// Whether panics of this thread are caught, so that nothing is printed of them.
    static CAUGHT: Cell<bool> = const { Cell::new(false) };
}

/// What a call of wgpu returns, or the message of its panic. Only for calls that panic where the device fails.
pub fn caught<T>(call: impl FnOnce() -> T) -> Result<T, String> {
    static SILENCED: Once = Once::new();
    SILENCED.call_once(|| {
        let print = take_hook();
        set_hook(Box::new(move |panic| {
            if !CAUGHT.get() {
                print(panic);
            }
        }));
    });
    CAUGHT.set(true);
    // wgpu has unlocked what it had locked. A device that failed is used no more.
    let result = catch_unwind(AssertUnwindSafe(call));
    CAUGHT.set(false);
    result.map_err(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
        format!("the driver failed: {}", text.unwrap_or_default())
    })
}

//! Turns panics of third-party parsers, decoders and wgpu into errors.
//!
//! Random edits of files made the parsers panic: gltf 1.4.1 in its validation if a POSITION names a missing accessor, and its
//! iterators at every invalid index. This does not help against failed allocations, which end the program. Therefore the sizes
//! that a file claims are compared with its real size before a parser reads it or memory is reserved.

use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Once;

thread_local! {
    /// Whether this thread's panics become errors; they are then not printed on stderr.
    static IS_GUARDED: Cell<bool> = const { Cell::new(false) };
}

/// The result of the parser, or the message of its panic. Values that the parser changed before the panic stay changed.
pub fn guarded<T>(parse: impl FnOnce() -> T) -> Result<T, String> {
    caught(parse).map_err(|message| format!("the parser gave up: {message}"))
}

/// The result of a call, or the message of its panic.
pub fn caught<T>(call: impl FnOnce() -> T) -> Result<T, String> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let before = panic::take_hook();
        panic::set_hook(Box::new(move |panic| {
            if !IS_GUARDED.get() {
                before(panic);
            }
        }));
    });
    let before = IS_GUARDED.replace(true);
    let result = panic::catch_unwind(AssertUnwindSafe(call));
    IS_GUARDED.set(before);
    result.map_err(|thrown| {
        let text = thrown.downcast_ref::<String>().map(String::as_str).or(thrown.downcast_ref::<&str>().copied());
        text.unwrap_or("it does not say why").to_string()
    })
}

#[cfg(test)]
mod tests {
    use super::guarded;

    #[test]
    fn a_panic_is_an_error_and_the_next_call_works() {
        let empty: &[u8] = std::hint::black_box(&[]);
        let gave_up = guarded(|| empty[7]).unwrap_err();
        assert!(gave_up.starts_with("the parser gave up: index out of bounds"), "{gave_up}");
        assert_eq!(guarded(|| guarded(|| panic!("{}", 1)).map(|()| 0)), Ok(Err("the parser gave up: 1".to_owned())));
        assert_eq!(guarded(|| 2), Ok(2));
    }
}

//! Calls of parsers that are not ours, which may panic on what a file says.
//!
//! They are kept behind this because random edits of files made them panic: tobj 4.0.5 on a corner such as
//! `1//6148914691236517206` (it multiplies the reference and indexes by the product), gltf 1.4.1 in its validation where a
//! POSITION names an accessor that there is not, and its iterators wherever an index leads nowhere. A panic is an error like
//! others here. That holds for panics only: a failing allocation ends the program, so what a file says about its own size is
//! held against the size that it has before a parser sees it or memory is reserved by it.

use std::any::Any;
use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Once;

thread_local! {
    /// Whether this thread's panics are turned into errors, and not to be told on stderr.
    static IS_GUARDED: Cell<bool> = const { Cell::new(false) };
}

/// What the parser gives, or its panic in words. What it has written to before it panics is left as it is.
pub fn guarded<T>(parse: impl FnOnce() -> T) -> Result<T, String> {
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
    let result = panic::catch_unwind(AssertUnwindSafe(parse));
    IS_GUARDED.set(before);
    result.map_err(|thrown| format!("the parser gave up: {}", message(&*thrown)))
}

fn message(thrown: &(dyn Any + Send)) -> &str {
    let text = thrown.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| thrown.downcast_ref::<&str>().copied()).unwrap_or("it does not say why")
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

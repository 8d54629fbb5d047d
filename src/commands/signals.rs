//! The signals that end a command: SIGINT, SIGTERM, SIGHUP, and SIGXCPU, the limit of processor time. SIGXFSZ, the limit of a file's size, ends
//! none.
//!
//! The first signal requests that the command finishes what is in flight and writes what it has. While a driver compiles, it ends the program at
//! once, because nothing else stops a driver. A second signal always ends the program at once, unless it is SIGXCPU, which the system sends
//! every second from the limit on.

use std::fmt;
use std::sync::atomic::{AtomicBool, AtomicI32, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use super::console::tell;
use crate::error::{Error, Result};
use crate::output::progress::remove_bar;

/// How long a signal may wait where a command waits for something else.
pub const WAIT: Duration = Duration::from_millis(100);

/// The signals that have come since the program listens.
#[derive(Clone, Debug, Default)]
pub struct Signals(Arc<Received>);

#[derive(Debug, Default)]
struct Received {
    /// The number of the first one; 0 before it.
    first: AtomicI32,
    /// Whether a request wants what a signal wants, of this program's present work alone.
    stop: AtomicBool,
    ending: Mutex<Ending>,
}

/// How a signal ends the program at once.
#[derive(Debug, Default)]
struct Ending {
    /// What is lost and what is kept, in words.
    loss: String,
    /// Set while the first signal ends the program: when that is, such as "while compiling".
    by_first: Option<&'static str>,
}

/// While it lives, the first signal ends the program.
pub struct EndsAtOnce<'a>(&'a Signals);

impl Drop for EndsAtOnce<'_> {
    fn drop(&mut self) {
        self.0.ending().by_first = None;
    }
}

impl Signals {
    /// Listens from now on. `loss` says what is lost if a signal ends the program at once.
    pub fn listen(loss: &str) -> Signals {
        let signals = Signals::default();
        signals.set_loss(loss.to_owned());
        // If that fails, a signal ends the program, as it did before.
        let _ = listen(&signals);
        signals
    }

    /// Whether one has come, or a request has the same effect.
    pub fn are_pending(&self) -> bool {
        self.have_come() || self.0.stop.load(Ordering::Relaxed)
    }

    /// Whether one has come.
    pub fn have_come(&self) -> bool {
        self.number() != 0
    }

    /// Sets whether a request stops the present work, as a signal does.
    pub fn set_stop(&self, stop: bool) {
        self.0.stop.store(stop, Ordering::SeqCst);
    }

    /// Changes what is lost if a signal ends the program at once.
    pub fn set_loss(&self, loss: String) {
        self.ending().loss = loss;
    }

    /// Lets the first signal end the program until the result is dropped. `when` says when that is, such as "while compiling".
    ///
    /// # Errors
    /// `Error::Interrupted` if a signal has come already.
    pub fn end_at_once(&self, when: &'static str) -> Result<EndsAtOnce<'_>> {
        let mut ending = self.ending();
        if self.are_pending() {
            return Err(self.interrupted(&ending.loss));
        }
        ending.by_first = Some(when);
        Ok(EndsAtOnce(self))
    }

    /// The error of a command that the first signal has ended. `words` say what is kept.
    pub fn interrupted(&self, words: &str) -> Error {
        Error::Interrupted { signal: self.number(), message: format!("interrupted by {self}; {words}") }
    }

    fn number(&self) -> i32 {
        self.0.first.load(Ordering::Relaxed)
    }

    fn ending(&self) -> MutexGuard<'_, Ending> {
        self.0.ending.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn take(&self, signal: i32) {
        if let Some(words) = self.last_words(signal) {
            remove_bar();
            tell(&words);
            // Without the functions that a driver has registered for a normal end: they wait for its threads.
            signal_hook::low_level::exit(128 + signal);
        }
    }

    /// The error of a signal that ends the program at once, and nothing for one that does not.
    fn last_words(&self, signal: i32) -> Option<String> {
        // The lock is held, so that a first signal is either noticed by `end_at_once` or meets what that has set.
        let Ending { loss, by_first } = &*self.ending();
        let is_first = self.0.first.compare_exchange(0, signal, Ordering::Relaxed, Ordering::Relaxed).is_ok();
        let name = name(signal);
        match (is_first, by_first) {
            (true, None) => None,
            (true, Some(when)) => Some(format!("error: interrupted by {name} {when}; {loss}")),
            (false, _) if is_of_processor_time(signal) => None,
            (false, _) => Some(format!("error: ended at once by a second signal, {name}; {loss}")),
        }
    }
}

/// The name of the first signal.
impl fmt::Display for Signals {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(name(self.number()))
    }
}

fn name(signal: i32) -> &'static str {
    if signal == 0 {
        return "a request";
    }
    signal_hook::low_level::signal_name(signal).unwrap_or("a signal")
}

#[cfg(unix)]
fn is_of_processor_time(signal: i32) -> bool {
    signal == libc::SIGXCPU
}

#[cfg(not(unix))]
fn is_of_processor_time(_: i32) -> bool {
    false
}

/// Whether a command listens, so that it deals with the limit of processor time itself.
#[cfg(unix)]
static LISTENS: AtomicBool = AtomicBool::new(false);

/// From now on limits of the system are errors. A file that grows beyond the limit of its size is an error of the write, as on a full disk.
/// The limit of processor time ends the program with a message, unless a command listens.
#[cfg(unix)]
pub fn catch_limits() {
    use signal_hook::{flag, low_level};
    // If that fails, a limit ends the program, as it did before.
    let _ = flag::register(libc::SIGXFSZ, Arc::default());
    let end = || {
        const LAST_WORDS: &[u8] = b"error: ended by SIGXCPU: the limit of processor time is reached\n";
        if !LISTENS.load(Ordering::Relaxed) {
            // SAFETY: `write` may be called in a handler of signals, with bytes that live as long as the program.
            unsafe { libc::write(libc::STDERR_FILENO, LAST_WORDS.as_ptr().cast(), LAST_WORDS.len()) };
            low_level::exit(128 + libc::SIGXCPU);
        }
    };
    if !is_ignored(libc::SIGXCPU) {
        // SAFETY: `end` calls nothing but what may be called in a handler of signals.
        let _ = unsafe { low_level::register(libc::SIGXCPU, end) };
    }
}

#[cfg(not(unix))]
pub fn catch_limits() {}

#[cfg(unix)]
fn listen(signals: &Signals) -> std::io::Result<()> {
    use libc::{SIGHUP, SIGINT, SIGTERM, SIGXCPU};
    let ending = [SIGINT, SIGTERM, SIGHUP, SIGXCPU].into_iter().filter(|signal| !is_ignored(*signal));
    let mut coming = signal_hook::iterator::Signals::new(ending)?;
    let signals = signals.clone();
    let wait = move || coming.forever().for_each(|signal| signals.take(signal));
    std::thread::Builder::new().name("signals".to_owned()).spawn(wait)?;
    LISTENS.store(true, Ordering::Relaxed);
    Ok(())
}

/// Whether a signal is ignored since the start, as under `nohup`. Then it stays ignored.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let mut action = std::mem::MaybeUninit::<libc::sigaction>::zeroed();
    // SAFETY: without a new action, `sigaction` only writes the present one; zeros are valid for its type.
    unsafe {
        libc::sigaction(signal, std::ptr::null(), action.as_mut_ptr()) == 0
            && action.assume_init().sa_sigaction == libc::SIG_IGN
    }
}

#[cfg(not(unix))]
fn listen(signals: &Signals) -> std::io::Result<()> {
    use signal_hook::consts::{SIGINT, SIGTERM};
    for signal in [SIGINT, SIGTERM] {
        let signals = signals.clone();
        // SAFETY: without signals of POSIX, the handler runs on a thread of its own.
        unsafe { signal_hook::low_level::register(signal, move || signals.take(signal)) }?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use signal_hook::consts::{SIGINT, SIGTERM};

    #[test]
    fn the_first_signal_is_the_reason_and_the_second_says_what_is_lost() {
        let signals = Signals::default();
        assert!(!signals.are_pending());
        assert_eq!(signals.last_words(SIGTERM), None);
        assert!(signals.are_pending());
        let error = signals.interrupted("a.exr holds the image so far");
        assert_eq!(error.to_string(), "interrupted by SIGTERM; a.exr holds the image so far");
        assert_eq!(error.exit_status(), 143);
        // The system sends this one again and again.
        #[cfg(unix)]
        signals.take(libc::SIGXCPU);
        assert_eq!(signals.to_string(), "SIGTERM");
        signals.set_loss("all is lost".to_owned());
        let says = "error: ended at once by a second signal, SIGINT; all is lost";
        assert_eq!(signals.last_words(SIGINT).as_deref(), Some(says));
    }

    /// A signal that comes before is an error where the first one would end the program, and one that comes after does not end it.
    #[test]
    fn the_first_signal_ends_the_program_only_while_drivers_compile() {
        let signals = Signals::default();
        signals.set_loss("nothing has been written".to_owned());
        drop(signals.end_at_once("while compiling").expect("no signal has come"));
        assert_eq!(signals.last_words(SIGINT), None);
        let error = signals.end_at_once("while compiling").err().expect("a signal has come");
        assert_eq!(error.to_string(), "interrupted by SIGINT; nothing has been written");

        let signals = Signals::default();
        signals.set_loss("nothing has been written".to_owned());
        let _ending = signals.end_at_once("while compiling").expect("no signal has come");
        let says = "error: interrupted by SIGINT while compiling; nothing has been written";
        assert_eq!(signals.last_words(SIGINT).as_deref(), Some(says));
    }
}

//! Runs the program, as its users do.

use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

/// When a program that does not end is killed.
const LIMIT: Duration = Duration::from_secs(120);

/// What a run of the program came to.
#[derive(Debug)]
pub struct Ran {
    pub status: ExitStatus,
    pub stdout: String,
    pub stderr: String,
}

/// The program in a folder; its output can be read.
pub fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gpu-rt"));
    command.current_dir(folder).args(arguments);
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    #[cfg(unix)]
    with_signals(&mut command, libc::SIG_DFL);
    command
}

/// Has the program start with signals that end it, or that it ignores. Tests in the background or under `nohup` would pass on that
/// theirs are ignored.
#[cfg(unix)]
pub fn with_signals(command: &mut Command, action: libc::sighandler_t) {
    use std::os::unix::process::CommandExt;
    let set = move || {
        for signal in [libc::SIGINT, libc::SIGTERM, libc::SIGHUP] {
            // SAFETY: `signal` may be called between fork and exec.
            unsafe { libc::signal(signal, action) };
        }
        Ok(())
    };
    // SAFETY: `set` calls nothing else.
    unsafe { command.pre_exec(set) };
}

/// Sends a signal to the program.
#[cfg(unix)]
pub fn send(child: &Child, signal: i32) {
    // SAFETY: the child has not been waited for, so the number is its own.
    let sent = unsafe { libc::kill(child.id() as i32, signal) };
    assert_eq!(sent, 0, "the signal is sent");
}

/// Waits until the program listens to signals: it has checked its outputs, and is about to compile.
#[cfg(target_os = "linux")]
pub fn until_listening(child: &mut Child) {
    let file = format!("/proc/{}/status", child.id());
    let caught = || {
        let status = std::fs::read_to_string(&file).unwrap_or_default();
        let set = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).map(str::trim);
        set.and_then(|set| u64::from_str_radix(set, 16).ok()).unwrap_or(0)
    };
    // Of those that end the program it is the last that is listened to.
    meanwhile(child, || caught() >> (libc::SIGHUP - 1) & 1 == 1);
}

/// The words of a command line without quotes and spaces in them.
pub fn words(line: &str) -> Vec<&str> {
    line.split_whitespace().collect()
}

/// Runs a command to its end.
pub fn ran(command: &mut Command) -> Ran {
    finish(command.spawn().expect("the program starts"))
}

/// Runs the program in a folder to its end, however long that takes.
pub fn run(folder: &Path, arguments: &[&str]) -> Ran {
    Ran::wait_for(command(folder, arguments).spawn().expect("the program starts"))
}

/// Waits for the program, and takes what it has printed. (Less than a pipe holds: no thread has to read meanwhile.)
pub fn finish(mut child: Child) -> Ran {
    until(&mut child, |child| child.try_wait().expect("the program can be asked").is_some());
    Ran::wait_for(child)
}

/// Waits until something is so.
pub fn until(child: &mut Child, mut is_so: impl FnMut(&mut Child) -> bool) {
    let start = Instant::now();
    while !is_so(child) {
        if start.elapsed() > LIMIT {
            let _ = child.kill();
            panic!("the program never comes so far");
        }
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Waits for a condition, while the program must not end.
pub fn meanwhile(child: &mut Child, is_so: impl Fn() -> bool) {
    until(child, |child| {
        let so = is_so();
        assert!(so || child.try_wait().expect("the program can be asked").is_none(), "it ended");
        so
    });
}

impl Ran {
    fn wait_for(child: Child) -> Ran {
        let output = child.wait_with_output().expect("its output can be read");
        let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
        Ran { status: output.status, stdout: text(output.stdout), stderr: text(output.stderr) }
    }

    pub fn code(&self) -> i32 {
        self.status.code().unwrap_or_else(|| panic!("ended by a signal: {self:?}"))
    }

    /// Asserts the exit status, and what holds for every run: no panic, no colours where nothing is a terminal.
    #[track_caller]
    pub fn exits(self, code: i32) -> Ran {
        assert!(!self.stderr.contains("panicked"), "{}", self.stderr);
        assert!(!self.stderr.contains('\u{1b}') && !self.stdout.contains('\u{1b}'), "colours: {self:?}");
        assert_eq!(self.code(), code, "{self:?}");
        // What is refused has no report, but for the one of --json.
        assert!(code != 2 || self.stdout.is_empty() || self.stdout.starts_with('{'), "{self:?}");
        self
    }

    /// Asserts that stderr has all these words.
    #[track_caller]
    pub fn on_stderr(self, words: &[&str]) -> Ran {
        words.iter().for_each(|words| assert!(self.stderr.contains(words), "{words}: {self:?}"));
        self
    }

    /// Asserts that the last line on stderr begins so.
    #[track_caller]
    pub fn says_last(self, start: &str) -> Ran {
        assert!(self.last_line().starts_with(start), "{start}: {self:?}");
        self
    }

    #[track_caller]
    pub fn on_stdout(self, words: &[&str]) -> Ran {
        words.iter().for_each(|words| assert!(self.stdout.contains(words), "{words}: {self:?}"));
        self
    }

    /// All of stdout as one JSON object.
    #[track_caller]
    pub fn json(&self) -> Value {
        let value: Value =
            serde_json::from_str(&self.stdout).unwrap_or_else(|error| panic!("{error}: {}", self.stdout));
        assert!(value.is_object(), "{value}");
        value
    }

    pub fn last_line(&self) -> &str {
        self.stderr.lines().last().unwrap_or_default()
    }
}

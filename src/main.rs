//! The program: reads the command line, runs the command, and prints errors.

use std::process::ExitCode;
use std::time::Instant;

use gpu_rt::commands::{self, Cli};
use gpu_rt::gpu::device::any_failed;

fn main() -> ExitCode {
    commands::catch_limits();
    let start = Instant::now();
    quiet_the_loader();
    let result = match Cli::read() {
        Ok(cli) => commands::run(&cli, start),
        // It quotes the arguments, which may be names of files.
        Err(error) if error.use_stderr() => {
            commands::tell(error.render().to_string().trim_end());
            return ExitCode::from(2);
        }
        Err(help) => commands::print_help(&help),
    };
    let status = match result {
        Ok(()) => 0,
        Err(error) => {
            commands::tell_error(&error);
            error.exit_status()
        }
    };
    if any_failed() {
        end_at_once(status);
    }
    ExitCode::from(status)
}

/// Ends the process without the destructors of libraries. A driver that failed may still be at work, and would lose its memory to
/// them.
#[cfg(unix)]
fn end_at_once(status: u8) {
    // SAFETY: it takes nothing, and does not return.
    unsafe { libc::_exit(i32::from(status)) }
}

#[cfg(not(unix))]
fn end_at_once(_: u8) {}

/// Mesa's device-select layer asks a Wayland server which GPU drives the screen, and complains on stderr if there is no
/// session. Without a session there is nothing to select.
fn quiet_the_loader() {
    let session = ["XDG_RUNTIME_DIR", "WAYLAND_DISPLAY", "DISPLAY", "MESA_VK_DEVICE_SELECT"];
    if session.iter().all(|name| std::env::var_os(name).is_none()) {
        // SAFETY: nothing else runs yet, so no other thread reads the environment.
        unsafe { std::env::set_var("NODEVICE_SELECT", "1") };
    }
}

//! What signals do to the program: the first one ends the work and keeps what it came to, the second one ends the program.

use crate::common::device::index as software;
use crate::common::program::{finish, meanwhile, ran, send, until, with_signals};
#[cfg(target_os = "linux")]
use crate::common::screen::{interrupted_on_terminal, screen};
use crate::sandbox::{ENDLESS, SPHERE, Sandbox, attribute, endless, make_pipe};
use std::cell::Cell;
use std::fs::{self, File};
use std::io::Write;
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use serde_json::Value;

#[test]
fn each_signal_keeps_the_image_and_has_its_exit_status() {
    for (signal, status, name) in [
        (libc::SIGINT, 130, "SIGINT"),
        (libc::SIGTERM, 143, "SIGTERM"),
        (libc::SIGHUP, 129, "SIGHUP"),
        (libc::SIGXCPU, 152, "SIGXCPU"),
    ] {
        let sandbox = Sandbox::new();
        let child = endless(&sandbox, &["--png", "sphere.png"]);
        send(&child, signal);
        let ran = finish(child).exits(status);
        let says = format!("error: interrupted by {name}; sphere.exr holds ");
        assert!(ran.last_line().starts_with(&says), "{}", ran.stderr);
        assert_eq!(attribute(&sandbox.exr("sphere.exr"), "gpu-rt:complete"), "0");
        assert_eq!(sandbox.files(), ["sphere.exr", "sphere.png"]);
    }
}

/// A command that starts with a limit, of which it is told by a signal.
fn limited(mut command: Command, resource: libc::__rlimit_resource_t, limit: u64) -> Command {
    let limit = libc::rlimit { rlim_cur: limit, rlim_max: libc::RLIM_INFINITY };
    let set = move || {
        // SAFETY: `setrlimit` may be called between fork and exec, and reads the structure during the call.
        match unsafe { libc::setrlimit(resource, &limit) } {
            0 => Ok(()),
            _ => Err(std::io::Error::last_os_error()),
        }
    };
    // SAFETY: `set` calls nothing else.
    unsafe { command.pre_exec(set) };
    command
}

/// The system says every second again that the time is over, which is no second signal.
#[test]
fn the_limit_of_processor_time_ends_a_render_as_an_interrupt_does() {
    let sandbox = Sandbox::new();
    let arguments = [&sandbox.render_sphere(), ["--spp", ENDLESS].as_slice()].concat();
    ran(&mut limited(sandbox.command(&arguments), libc::RLIMIT_CPU, 2))
        .exits(152)
        .says_last("error: interrupted by SIGXCPU; sphere.exr holds ");
    assert_eq!(attribute(&sandbox.exr("sphere.exr"), "gpu-rt:complete"), "0");
}

/// A limit of a file's size is an error of what is written, also before anything is rendered; not of the driver's cache of kernels.
#[test]
fn the_limit_of_a_file_is_an_error_of_the_write() {
    let sandbox = Sandbox::new();
    let run = |arguments: &[&str], limit: u64| {
        let cache = tempfile::tempdir().expect("a temporary folder");
        let mut command = limited(sandbox.command(arguments), libc::RLIMIT_FSIZE, limit);
        command.env("MESA_SHADER_CACHE_DIR", cache.path());
        let told = File::create(sandbox.folder.path().join("told")).expect("it is created");
        ran(command.stdout(told))
    };
    run(&sandbox.render_sphere(), 1 << 10).exits(1).says_last("error: sphere.exr: cannot write: File too large");
    assert_eq!(sandbox.files(), Vec::<String>::new());
    // The cache of one kernel is larger.
    run(&sandbox.render_sphere(), 32 << 10).exits(0);
    sandbox.exr("sphere.exr");
    for arguments in [&["completions", "bash"][..], &["--help"]] {
        run(arguments, 100).exits(1).says_last("error: stdout: cannot write: File too large");
    }
}

/// Limits are errors before a command listens for signals, and where none does.
#[test]
fn limits_are_errors_of_commands_that_no_signal_interrupts() {
    let sandbox = Sandbox::new();
    let pipe = sandbox.at("pipe.ron");
    make_pipe(&pipe);
    let begun = || {
        let child = sandbox.command(&["check", "pipe.ron"]).spawn().expect("the program starts");
        // It opens once the program does.
        (child, File::options().write(true).open(&pipe).expect("it is opened"))
    };
    let (child, open) = begun();
    send(&child, libc::SIGXCPU);
    let ran = finish(child).exits(152);
    assert_eq!(ran.stderr, "error: ended by SIGXCPU: the limit of processor time is reached\n");
    drop(open);
    let (child, mut open) = begun();
    send(&child, libc::SIGXFSZ);
    open.write_all(SPHERE.as_bytes()).expect("it reads");
    drop(open);
    finish(child).exits(0);
    // What was ignored at the start stays so.
    let mut command = sandbox.command(&["check", "pipe.ron"]);
    let ignore = || {
        // SAFETY: `signal` may be called between fork and exec.
        unsafe { libc::signal(libc::SIGXCPU, libc::SIG_IGN) };
        Ok(())
    };
    // SAFETY: `ignore` calls nothing else.
    unsafe { command.pre_exec(ignore) };
    let child = command.spawn().expect("the program starts");
    let mut open = File::options().write(true).open(&pipe).expect("it is opened");
    send(&child, libc::SIGXCPU);
    open.write_all(SPHERE.as_bytes()).expect("it reads");
    drop(open);
    finish(child).exits(0);
}

/// A driver that compiles cannot be stopped, and takes seconds. The progress says how far it is.
#[cfg(target_os = "linux")]
#[test]
fn a_signal_while_compiling_ends_the_program_within_a_second() {
    let sandbox = Sandbox::new();
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/still-life.glb");
    let arguments = ["render", scene, "--device", software(), "--size", "16x9", "-o", "a.exr"];
    let file = || fs::read(sandbox.at("a.exr")).ok();
    let resumes = "--size 16x9 --spp 16 --json -o a.exr --resume` goes on";
    for (signal, status, name, more) in [
        (libc::SIGTERM, 143, "SIGTERM", &["--spp", "8", "--json"][..]),
        (libc::SIGHUP, 129, "SIGHUP", &["--watch"]),
        (libc::SIGINT, 130, "SIGINT", &["--spp", "16", "--json", "--resume"]),
    ] {
        let before = file();
        let mut command = sandbox.command(&[&arguments[..], more].concat());
        command.env("MESA_SHADER_CACHE_DISABLE", "true");
        let sent = Cell::new(None);
        let (ended, text) = interrupted_on_terminal(command, 500, signal, |text| {
            let is_enough = text.contains("compiling ");
            sent.set(sent.get().or(is_enough.then(Instant::now)));
            is_enough
        });
        let took = sent.get().expect("it compiles for a moment").elapsed();
        assert!(took < Duration::from_secs(1), "{took:?}");
        assert_eq!(ended, Some(status), "{text}");
        // The bar is gone, and no report is made.
        let screen = screen(&text);
        assert!(screen.iter().all(|row| !row.contains("compiling ") && !row.contains('{')), "{screen:#?}");
        let last = screen.iter().rfind(|row| !row.is_empty()).expect("it says something");
        let kept =
            if before.is_some() { "a.exr holds 8 samples per pixel. `gpu-rt " } else { "nothing has been written" };
        let says = format!("error: interrupted by {name} while compiling; {kept}");
        assert!(last.starts_with(&says) && last.ends_with(resumes) == before.is_some(), "{screen:#?}");
        assert!(file() == before);
        if signal == libc::SIGHUP {
            sandbox.run(&[&arguments[..], &["--spp", "8"]].concat()).exits(0);
        }
    }
}

/// Waits until the program has written the file anew.
fn next_checkpoint(child: &mut std::process::Child, file: &Path) {
    let time = || fs::metadata(file).and_then(|found| found.modified()).expect("the file is there");
    let before = time();
    meanwhile(child, || time() != before);
}

#[test]
fn a_signal_that_nohup_ignores_stays_ignored() {
    let sandbox = Sandbox::new();
    let arguments = [&sandbox.render_sphere(), ["--spp", ENDLESS, "--checkpoint", "50ms"].as_slice()].concat();
    let mut command = sandbox.command(&arguments);
    with_signals(&mut command, libc::SIG_IGN);
    let mut child = command.spawn().expect("the program starts");
    let file = sandbox.at("sphere.exr");
    meanwhile(&mut child, || file.exists());
    for signal in [libc::SIGHUP, libc::SIGTERM, libc::SIGINT] {
        send(&child, signal);
        next_checkpoint(&mut child, &file);
        next_checkpoint(&mut child, &file);
    }
    child.kill().expect("the program can be killed");
    child.wait().unwrap();
}

/// The PNG is a pipe without a reader: there the program waits until the second signal.
#[test]
fn a_second_signal_ends_the_program_while_it_writes() {
    let sandbox = Sandbox::new();
    make_pipe(&sandbox.at("pipe"));
    let arguments = [&sandbox.render_sphere(), ["--png", "pipe", "--checkpoint", "1h"].as_slice()].concat();
    let mut child = sandbox.command(&arguments).spawn().expect("the program starts");
    // Without an earlier checkpoint, it is the full image.
    meanwhile(&mut child, || sandbox.at("sphere.exr").exists());
    until(&mut child, |child| {
        send(child, libc::SIGTERM);
        child.try_wait().expect("the program can be asked").is_some()
    });
    let ran = finish(child).exits(143);
    let says = "error: ended at once by a second signal, SIGTERM; sphere.exr holds the image";
    assert_eq!(ran.last_line(), says, "{}", ran.stderr);
    assert_eq!(attribute(&sandbox.exr("sphere.exr"), "gpu-rt:complete"), "1");
}

/// Behind the first signal the program may come to its end, which takes a tenth of a second: in one of twenty it does not. Which of
/// two signals at once is the second one is not known.
#[test]
fn a_second_signal_says_what_is_lost() {
    let is_lost = |_| {
        let sandbox = Sandbox::new();
        let child = endless(&sandbox, &[]);
        send(&child, libc::SIGINT);
        send(&child, libc::SIGHUP);
        let ran = finish(child);
        let second = if ran.code() == 129 { "SIGHUP" } else { "SIGINT" };
        let lost =
            format!("a second signal, {second}; the samples since the last checkpoint are lost. sphere.exr holds ");
        let resumes = "--checkpoint 50ms -o sphere.exr --resume` goes on";
        assert!([129, 130].contains(&ran.code()), "{ran:?}");
        sandbox.exr("sphere.exr");
        ran.last_line().contains(&lost) && ran.last_line().ends_with(resumes)
    };
    assert!((0..20).any(is_lost));
}

#[test]
fn an_interrupted_convergence_keeps_its_rows() {
    let sandbox = Sandbox::new();
    sandbox.render(&["-o", "reference.exr"]).exits(0);
    let said = sandbox.folder.path().join("said");
    let arguments = ["converge", "../scenes/sphere.ron", "--reference", "reference.exr", "--spp", ENDLESS];
    let mut command = sandbox.command(&[&arguments[..], &["--device", software()]].concat());
    let mut child = command.stdout(fs::File::create(&said).unwrap()).spawn().expect("the program starts");
    meanwhile(&mut child, || fs::read_to_string(&said).unwrap().lines().count() > 3);
    send(&child, libc::SIGHUP);
    let ran = finish(child).exits(129);
    let says = "interrupted by SIGHUP; ./sphere-converge.csv holds the samples so far";
    assert!(ran.last_line().ends_with(says), "{}", ran.stderr);
    assert!(fs::read_to_string(sandbox.at("sphere-converge.csv")).unwrap().lines().count() > 3);
}

#[test]
fn an_interrupt_writes_the_image_and_reports_the_samples_that_it_has() {
    let sandbox = Sandbox::new();
    let child = endless(&sandbox, &["--json"]);
    send(&child, libc::SIGINT);
    let ran = finish(child).exits(130);
    assert!(ran.stderr.contains("SIGINT: ending the samples under way"), "{}", ran.stderr);
    assert_eq!(sandbox.files(), ["sphere.exr"]);
    let image = sandbox.exr("sphere.exr");
    let samples = image.samples.as_ref().expect("a layer of samples");
    // Whole runs, of 8 samples: no path is cut off, and none dropped.
    assert!(samples.iter().all(|n| n.is_multiple_of(8)), "{samples:?}");
    let (least, most) = (*samples.iter().min().unwrap(), *samples.iter().max().unwrap());
    assert!(most > 0);
    let all = samples.iter().map(|&n| u64::from(n)).sum::<u64>();
    assert_eq!(attribute(&image, "gpu-rt:paths").parse::<u64>().unwrap(), all);
    assert_eq!(attribute(&image, "gpu-rt:complete"), "0");
    // The report, the line about the image, and the header do not claim the requested samples.
    let reported = ran.json()["samples_per_pixel"].as_u64().expect("a number");
    assert!((least..=most).contains(&(reported as u32)), "{reported} are reported, the pixels have {least}..={most}");
    assert!(!ran.stderr.contains(&format!("{ENDLESS} samples")), "{}", ran.stderr);
    assert_ne!(attribute(&image, "gpu-rt:end_sample"), ENDLESS);
}

/// A measurement that is interrupted when `ready` says so of what it has said on stderr. The result is that, and the report.
fn interrupted_tradeoff(sandbox: &Sandbox, ready: impl Fn(&str) -> bool, says: &str) -> (String, Value) {
    sandbox.scene("large.ron", &SPHERE.replace("width: 20, height: 12", "width: 96, height: 96"));
    let said = sandbox.folder.path().join("said");
    let arguments = ["tradeoff", "../scenes/large.ron", "--budget", "1h", "--knobs", "roulette,clamp"];
    let mut command = sandbox.command(&[&arguments[..], &["-o", "report", "--device", software()]].concat());
    let mut child = command.stderr(fs::File::create(&said).unwrap()).spawn().expect("the program starts");
    meanwhile(&mut child, || ready(&fs::read_to_string(&said).unwrap()));
    send(&child, libc::SIGTERM);
    let ran = finish(child).exits(143);
    let said = fs::read_to_string(&said).unwrap();
    assert!(said.trim_end().ends_with(says), "{said}");
    assert!(
        ran.stdout.contains("of 5 settings measured at 96x96")
            || ran.stdout.contains("of 5 settings measured at 32x32"),
        "{ran:?}"
    );
    assert!(ran.stdout.lines().any(|line| line.starts_with("setting ")), "{ran:?}");
    let folder = sandbox.at("report");
    assert!(fs::read_to_string(folder.join("index.html")).unwrap().ends_with("</html>\n"));
    let report = serde_json::from_slice(&fs::read(folder.join("tradeoff.json")).unwrap()).expect("an object");
    let rows = fs::read_to_string(folder.join("tradeoff.csv")).unwrap().lines().count();
    // The head, the defaults, roulette off, and three limits.
    assert_eq!(rows, 1 + 5, "{report}");
    (said, report)
}

#[test]
fn an_interrupted_tradeoff_reports_what_was_measured() {
    let sandbox = Sandbox::new();
    let says = "interrupted by SIGTERM; report holds what was measured";
    let (said, report) = interrupted_tradeoff(&sandbox, |said| said.contains("3 rounds are measured"), says);
    assert_eq!(report["interrupted"], true, "{said}");
    let settings = report["settings"].as_array().unwrap();
    assert!(settings.iter().all(|setting| setting["measured"] == true), "{report:#}");
    assert!(settings.iter().all(|setting| (3..32).contains(&setting["rounds"].as_u64().unwrap())), "{report:#}");
    assert!(sandbox.at("report/plot.svg").exists());
}

#[test]
fn a_tradeoff_that_is_interrupted_at_once_says_that_nothing_is_measured() {
    let sandbox = Sandbox::new();
    let folder = sandbox.at("report");
    let says = "interrupted by SIGTERM; nothing was measured before";
    let (said, report) = interrupted_tradeoff(&sandbox, |_| folder.exists(), says);
    assert_eq!(report["interrupted"], true, "{said}");
    for setting in report["settings"].as_array().unwrap() {
        assert_eq!(setting["measured"], false, "{report:#}");
        assert_eq!(setting["verdict"], "not measured: interrupted before it was measured", "{report:#}");
    }
    assert_eq!(report["recommendations"][1]["words"], "a relative MSE of 1e-2 (10.0 %): nothing was measured");
}

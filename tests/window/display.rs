//! A real window, on displays that nobody sees: Xvfb, with the mouse and the keys of xdotool, and Weston.

use std::io::{BufRead, BufReader};
use std::os::unix::fs::PermissionsExt;
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::thread::{sleep, spawn};
use std::time::{Duration, Instant};

use crate::common::device::index;
use crate::common::fault::Fault;
use crate::common::program::{command, send, words};
use crate::common::scenes::SPHERE;

const LIMIT: Duration = Duration::from_secs(120);

/// A display, until it is dropped.
struct Display {
    server: Child,
    name: String,
}

impl Display {
    fn new() -> Display {
        let mut server = Command::new("Xvfb");
        server.args(["-displayfd", "1", "-screen", "0", "1280x800x24", "-nolisten", "tcp", "-noreset"]);
        server.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut server = server.spawn().expect("Xvfb starts: apt-get install xvfb");
        let mut number = String::new();
        let mut output = BufReader::new(server.stdout.take().expect("it is a pipe"));
        output.read_line(&mut number).expect("Xvfb says its number");
        Display { server, name: format!(":{}", number.trim()) }
    }

    /// What xdotool prints; it fails while there is no window.
    fn tool(&self, line: &str) -> Option<String> {
        let output = Command::new("xdotool").args(words(line)).env("DISPLAY", &self.name).output();
        let output = output.expect("xdotool starts: apt-get install xdotool");
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

/// The program with a window.
struct Opened {
    child: Child,
    said: Arc<Mutex<String>>,
    folder: tempfile::TempDir,
}

impl Opened {
    fn new(display: &Display, options: &str, fault: Option<&Fault>) -> Opened {
        let mut opened = Opened::with(options, |program| {
            program.env("DISPLAY", &display.name).env_remove("WAYLAND_DISPLAY");
            if let Some(fault) = fault {
                fault.put_under(program);
            }
        });
        opened.until("the window", |_| display.tool("search --onlyvisible --name sphere").is_some());
        // No window manager does that here.
        opened.until("the focus", |_| display.tool("search --name sphere windowfocus --sync %1").is_some());
        opened
    }

    /// Starts the program in another environment.
    fn with(options: &str, change: impl FnOnce(&mut Command)) -> Opened {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let scene = SPHERE.replace("(width: 20, height: 12)", "(width: 320, height: 200)");
        std::fs::write(folder.path().join("sphere.ron"), scene).expect("the scene is written");
        let line = format!("view sphere.ron --device {} {options}", index());
        let mut program = command(folder.path(), &words(&line));
        change(program.env("LIBGL_ALWAYS_SOFTWARE", "1"));
        let mut child = program.spawn().expect("the program starts");
        let said = Arc::<Mutex<String>>::default();
        let (theirs, errors) = (Arc::clone(&said), BufReader::new(child.stderr.take().expect("it is a pipe")));
        spawn(move || errors.lines().map_while(Result::ok).for_each(|line| *theirs.lock().unwrap() += &(line + "\n")));
        Opened { child, said, folder }
    }

    fn said(&self) -> String {
        self.said.lock().unwrap().clone()
    }

    /// Waits, while the program must not end.
    #[track_caller]
    fn until(&mut self, what: &str, is_so: impl Fn(&Opened) -> bool) {
        let begin = Instant::now();
        while !is_so(self) {
            let ended = self.child.try_wait().expect("it can be asked");
            assert!(ended.is_none() && begin.elapsed() < LIMIT, "never: {what}: {ended:?} {}", self.said());
            sleep(Duration::from_millis(20));
        }
    }

    /// Saves the image, which needs some samples, and waits for the file.
    #[track_caller]
    fn save(&mut self, display: &Display, name: &str) {
        let path = self.folder.path().join(name);
        display.tool("key s").expect("a key");
        self.until(name, |_| path.exists());
    }

    /// The exit status, once it has ended, and what it has said.
    #[track_caller]
    fn end(&mut self) -> (Option<i32>, String) {
        let begin = Instant::now();
        loop {
            if let Some(status) = self.child.try_wait().expect("it can be asked") {
                sleep(Duration::from_millis(50));
                assert!(!self.said().contains("panicked"), "{}", self.said());
                return (status.code(), self.said());
            }
            assert!(begin.elapsed() < Duration::from_secs(20), "it goes on: {}", self.said());
            sleep(Duration::from_millis(10));
        }
    }
}

impl Drop for Opened {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The window: a drag turns the camera, which is said at the end; other sizes of the window; an image that is saved; Ctrl-C.
#[test]
fn a_window_is_dragged_resized_and_interrupted() {
    let display = Display::new();
    let mut opened = Opened::new(&display, "--spp 1000000", None);
    opened.save(&display, "sphere.exr");
    for line in ["mousemove 200 150", "mousedown 1", "mousemove 230 150", "mousemove 260 170", "mouseup 1"] {
        display.tool(line).expect("the mouse moves");
        sleep(Duration::from_millis(50));
    }
    opened.save(&display, "sphere.2.exr");
    for size in ["500 300", "1200 780", "300 200", "900 600"] {
        display
            .tool(&format!("search --name sphere windowsize --sync %1 {size}"))
            .expect("the window has another size");
    }
    display.tool("key c").expect("a key");
    opened.until("the camera", |opened| opened.said().contains("camera: (look_from"));
    send(&opened.child, libc::SIGINT);
    let (status, said) = opened.end();
    assert_eq!(status, Some(130), "{said}");
    assert!(said.contains("interrupted by SIGINT") && !said.contains("look_from: (0.0, 0.0, 3.0)"), "{said}");
    let image = |name| std::fs::read(opened.folder.path().join(name)).expect("a PNG");
    assert_ne!(image("sphere.png"), image("sphere.2.png"), "the drag shows another view");
    let scene = std::fs::read_to_string(opened.folder.path().join("sphere.ron")).expect("the scene");
    assert!(scene.contains("look_from: (0, 0, 3)"), "the file stays as it is");
}

/// Closing the window is no error, also while the first kernels compile.
#[test]
fn a_window_is_closed() {
    let display = Display::new();
    for waits in [false, true] {
        let mut opened = Opened::new(&display, "", None);
        if waits {
            opened.save(&display, "sphere.exr");
        }
        display.tool("key q").expect("a key");
        let (status, said) = opened.end();
        assert_eq!(status, Some(0), "{said}");
    }
}

/// Another program may destroy the window.
#[test]
fn a_window_that_is_destroyed_is_an_error() {
    let display = Display::new();
    let mut opened = Opened::new(&display, "", None);
    opened.save(&display, "sphere.exr");
    display.tool("search --name sphere windowclose").expect("it is destroyed");
    let (status, said) = opened.end();
    assert_eq!(status, Some(1), "{said}");
    assert!(said.contains("error: the display has failed"), "{said}");
}

#[test]
fn without_a_display_the_arguments_are_to_blame() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("sphere.ron"), SPHERE).expect("the scene is written");
    for display in [None, Some(":4242")] {
        let mut program = command(folder.path(), &["view", "sphere.ron", "--device", index()]);
        program.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
        if let Some(display) = display {
            program.env("DISPLAY", display);
        }
        let words = ["error: there is no display", "`gpu-rt render --preview`"];
        let ran = crate::common::program::ran(&mut program).exits(2).on_stderr(&words);
        assert!(!ran.stderr.contains(".rs:"), "a message names no source: {}", ran.stderr);
    }
}

/// Weston without a screen: the window opens, closes by a signal, and says when Wayland has gone.
#[test]
fn on_wayland_the_window_opens_and_ends() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::set_permissions(folder.path(), std::fs::Permissions::from_mode(0o700)).expect("the folder is ours");
    let mut weston = Command::new("weston");
    weston.args(["--backend=headless-backend.so", "--socket=wayland-test", "--idle-time=0"]);
    weston.env("XDG_RUNTIME_DIR", folder.path()).stdout(Stdio::null()).stderr(Stdio::null());
    let server = weston.spawn().expect("weston starts: apt-get install weston");
    let mut display = Display { server, name: "wayland-test".to_owned() };
    let socket = folder.path().join(&display.name);
    let begin = Instant::now();
    while !socket.exists() {
        assert!(begin.elapsed() < LIMIT, "weston does not listen");
        sleep(Duration::from_millis(20));
    }
    for goes in [false, true] {
        let mut opened = Opened::with("--spp 1000000", |program| {
            program.env_remove("DISPLAY").env("WAYLAND_DISPLAY", &display.name).env("XDG_RUNTIME_DIR", folder.path());
            // The library of Wayland prints each request: the first picture is one.
            program.env("WAYLAND_DEBUG", "1");
        });
        opened.until("the window", |opened| {
            opened.said().lines().any(|line| line.contains(".attach(") || line.contains(".commit("))
        });
        match goes {
            true => display.server.kill().expect("it is killed"),
            false => send(&opened.child, libc::SIGTERM),
        }
        let (status, said) = opened.end();
        let told: Vec<&str> = said.lines().filter(|line| line.starts_with("error: ")).collect();
        let (expected, words) =
            if goes { (1, "error: the display has failed") } else { (143, "error: interrupted by SIGTERM") };
        assert!(status == Some(expected) && told.len() == 1 && told[0].starts_with(words), "{status:?} {told:?}");
    }
}

/// A display that goes, as with a connection that breaks, ends the program, which says so.
#[test]
fn a_display_that_goes_ends_the_program() {
    for waits in [false, true] {
        let mut display = Display::new();
        let mut opened = Opened::new(&display, "--spp 1000000", None);
        if waits {
            opened.save(&display, "sphere.exr");
        }
        display.server.kill().expect("it is killed");
        let (status, said) = opened.end();
        assert_eq!(status, Some(1), "{said}");
        // In words of the library that speaks with the display.
        assert!(said.contains("X connection") || said.contains("X server"), "{said}");
    }
}

/// A device that is lost once is opened again. One that stays lost is an error in a window that stays.
#[test]
fn a_lost_device_leaves_the_window_open() {
    let display = Display::new();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let once = Fault::once(folder.path(), "vkQueueSubmit", 60, "lost");
    let mut opened = Opened::new(&display, "--spp 1000000", Some(&once));
    opened.until("the loss", |_| once.has_happened());
    opened.save(&display, "sphere.exr");
    assert!(opened.said().contains("lost"), "{}", opened.said());
    send(&opened.child, libc::SIGTERM);
    assert_eq!(opened.end().0, Some(143));
    let always = Fault::new(folder.path(), "vkQueueSubmit", 60, "lost");
    let mut opened = Opened::new(&display, "--spp 1000000", Some(&always));
    opened.until("the error", |opened| opened.said().contains("error: "));
    sleep(Duration::from_secs(1));
    send(&opened.child, libc::SIGINT);
    assert_eq!(opened.end().0, Some(130), "{}", opened.said());
}

//! Where the program writes: what it refuses before it renders, and what becomes of files that are in use, in danger, or no files.

use crate::common::device::index as software;
#[cfg(target_os = "linux")]
use crate::common::fault::on_full_disk;
use crate::common::oidn;
#[cfg(target_os = "linux")]
use crate::common::program::until_listening;
use crate::common::program::{finish, meanwhile, ran, send, words};
use crate::resume::Held;
use crate::sandbox::{ENDLESS, SPHERE, Sandbox, attribute, endless, make_pipe, names};
use std::fs::{self, File};
use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process::Child;

use gpu_rt::output::exr::read_exr;

// Before rendering

#[test]
fn destinations_that_cannot_be_written_are_refused_before_rendering() {
    let sandbox = Sandbox::new();
    fs::write(sandbox.at("file"), "").unwrap();
    fs::create_dir(sandbox.at("folder")).unwrap();
    symlink("missing/a.exr", sandbox.at("link")).unwrap();
    symlink("loop", sandbox.at("loop")).unwrap();
    let too_long = "n".repeat(256);
    let mut outputs = vec![
        ("missing/a.exr", "the folder missing does not exist"),
        ("link", "the folder missing does not exist"),
        ("loop", "symbolic links"),
        ("file/a.exr", "Not a directory"),
        ("folder", "it is a folder"),
        ("folder/", "it is a folder"),
        ("new/", "it names no file"),
        (".", "it is a folder"),
        (&too_long, "File name too long"),
    ];
    if cfg!(target_os = "linux") {
        // A folder where not even root may make files.
        outputs.push(("/proc/sys/a.exr", "no file can be made in its folder"));
    }
    for (output, words) in outputs {
        for option in ["-o", "--png"] {
            let ran = sandbox.refuses(&[option, output]);
            let says = format!("error: {output}: cannot write: ");
            assert!(ran.last_line().starts_with(&says) && ran.last_line().contains(words), "{option}: {}", ran.stderr);
            assert!(ran.last_line().contains(&format!("Give another name with {option}")), "{}", ran.stderr);
        }
    }
}

#[test]
fn the_longest_names_are_written() {
    let sandbox = Sandbox::new();
    for length in [243, 255] {
        let [exr, png] = ["exr", "png"].map(|ending| format!("{}.{ending}", "n".repeat(length - 4)));
        sandbox.render(&["-o", &exr, "--png", &png, "--checkpoint", "1ms"]).exits(0);
        assert_eq!(sandbox.files(), [&exr[..], &png]);
        fs::remove_file(sandbox.at(exr)).unwrap();
        fs::remove_file(sandbox.at(png)).unwrap();
    }
}

#[test]
fn two_outputs_are_never_one_file() {
    let sandbox = Sandbox::new();
    fs::create_dir(sandbox.at("sub")).unwrap();
    fs::write(sandbox.at("old"), "old").unwrap();
    fs::hard_link(sandbox.at("old"), sandbox.at("hard")).unwrap();
    symlink("old", sandbox.at("link")).unwrap();
    symlink("sub/new", sandbox.at("dangling")).unwrap();
    make_pipe(&sandbox.at("pipe"));
    let absolute = sandbox.at("new");
    for (exr, png) in [
        ("new", "new"),
        ("new", "./new"),
        ("new", "sub/../new"),
        ("new", absolute.to_str().unwrap()),
        ("sub/new", "dangling"),
        ("old", "link"),
        ("hard", "link"),
        ("pipe", "sub/../pipe"),
    ] {
        let ran = sandbox.refuses(&["-o", exr, "--png", png]);
        assert!(ran.last_line().contains(&format!("{png}: --png names the same file as -o {exr}")), "{}", ran.stderr);
    }
    assert_eq!(fs::read_to_string(sandbox.at("old")).unwrap(), "old");
    sandbox.render(&["-o", "/dev/null", "--png", "/dev/null"]).exits(0);
}

/// A folder where the scene `studio.ron` is lit by `studio.exr`, and has three meshes.
fn studio() -> (Sandbox, Vec<&'static str>) {
    let sandbox = Sandbox::new();
    sandbox.render(&["-o", "studio.exr"]).exits(0);
    fs::write(sandbox.at("face.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let numbers: Vec<u8> =
        [0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|v| v.to_le_bytes()).collect();
    fs::write(sandbox.at("face.bin"), numbers).unwrap();
    let gltf = r#"{"asset": {"version": "2.0"}, "buffers": [{"uri": "%66ace.bin", "byteLength": 36}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}]}"#;
    fs::write(sandbox.at("face.gltf"), gltf).unwrap();
    image::RgbImage::new(1, 1).save(sandbox.at("black.png")).unwrap();
    let scene = SPHERE
        .replace("Gradient(bottom: (1, 1, 1), top: (0.5, 0.7, 1))", "Image(path: \"studio.exr\")")
        .replace("{ \"grey\":", "{ \"black\": Lambertian(albedo: Image(path: \"black.png\")), \"grey\":")
        .replace("radius: 1, material: \"grey\"", "radius: 1, material: \"black\"")
        .replace(
            "objects: [",
            "objects: [Mesh(path: \"face.obj\", material: \"grey\"), Mesh(path: \"face.gltf\", material: \"grey\"), ",
        );
    fs::write(sandbox.at("studio.ron"), scene).unwrap();
    (sandbox, vec!["studio.ron", "studio.exr", "black.png", "face.obj", "face.gltf", "face.bin"])
}

#[test]
fn an_output_is_never_an_input_of_the_scene() {
    let (sandbox, inputs) = studio();
    let contents = || inputs.iter().map(|name| fs::read(sandbox.at(name)).unwrap()).collect::<Vec<_>>();
    let before = contents();
    let render = ["render", "studio.ron", "--device", software(), "--spp", ENDLESS];
    fs::create_dir(sandbox.at("sub")).unwrap();
    for name in &inputs {
        let _ = fs::remove_file(sandbox.at("link"));
        symlink(format!("sub/../{name}"), sandbox.at("link")).unwrap();
        let spelling = format!("sub/../{name}");
        for option in ["-o", "--png"] {
            for output in [name, &spelling[..], "link"] {
                let ran = sandbox.run(&[&render[..], &[option, output, "--quiet"]].concat()).exits(2);
                // Where the EXR has its default name, which is an input too, that is said first.
                let says = match option {
                    "-o" => format!("error: {output}: it would overwrite the input {name}: give another name with -o"),
                    _ => "it would overwrite the input ".to_owned(),
                };
                assert!(ran.last_line().contains(&says), "{}", ran.stderr);
            }
        }
        let ran = sandbox.run(&[&render[..], &["-o", "new.exr", "--png", name]].concat()).exits(2);
        let says = format!("{name}: it would overwrite the input {name}: give another name with --png");
        assert!(ran.last_line().contains(&says), "{}", ran.stderr);
    }
    // By its default name.
    let ran = sandbox.run(&render).exits(2);
    let says = "error: studio.exr: it would overwrite the input studio.exr: give another name with -o";
    assert!(ran.last_line().starts_with(says), "{}", ran.stderr);
    assert!(contents() == before);
    sandbox.run(&["render", "studio.ron", "--device", software(), "--spp", "1", "-o", "new.exr"]).exits(0);
}

/// That is found before anything is read: these are no images.
#[test]
fn merge_overwrites_none_of_its_parts() {
    let sandbox = Sandbox::new();
    for name in ["a.exr", "b.exr"] {
        fs::write(sandbox.at(name), name).unwrap();
    }
    let ran = sandbox.says("merge a.exr b.exr -o ../work/b.exr").exits(2);
    let says =
        "error: ../work/b.exr: it would overwrite the input b.exr: give another name with -o; nothing has been joined";
    assert_eq!(ran.last_line(), says);
    assert_eq!(fs::read_to_string(sandbox.at("b.exr")).unwrap(), "b.exr");
}

/// A temporary file without a lock was left by a writer that died; one with a lock is being written.
#[test]
fn temporary_files_of_dead_writers_go_at_the_next_start() {
    let sandbox = Sandbox::new();
    let hash = crc32fast::hash(b"sphere.exr");
    let [stale, live] = ["stale", "alive"].map(|letters| format!(".gpu-rt-{hash:08x}-1-{letters}.part"));
    fs::write(sandbox.at(&stale), "").unwrap();
    let writer = File::create(sandbox.at(&live)).unwrap();
    writer.lock().unwrap();
    sandbox.render(&[]).exits(0);
    assert_eq!(sandbox.files(), [&live[..], "sphere.exr"]);
    // Dropping it would not do: a process that another test is about to start may still share the lock.
    writer.unlock().unwrap();
    sandbox.render(&[]).exits(0);
    assert_eq!(sandbox.files(), ["sphere.exr"]);
}

/// `merge` is killed before each of its calls on files, from its first temporary file on. That file has no name until it is complete. A new
/// image has its own name at once. One that replaces another has a temporary name in between, and the next start removes what a kill leaves.
#[cfg(target_os = "linux")]
#[test]
fn a_killed_merge_leaves_nothing() {
    use crate::common::kills::kill_before;
    use std::os::unix::fs::OpenOptionsExt;
    let sandbox = Sandbox::new();
    for samples in ["0..8", "8..16"] {
        sandbox.render(&["--quiet", "--samples", samples, "-o", &format!("{samples}.exr")]).exits(0);
    }
    let merge = ["merge", "--quiet", "0..8.exr", "8..16.exr", "-o", "out.exr"];
    let out = sandbox.at("out.exr");
    sandbox.run(&merge).exits(0);
    let complete = fs::read(&out).unwrap();
    for old in [None, Some("old")] {
        let (mut kills, mut left, mut replaced) = (0, 0, 0);
        loop {
            match old {
                Some(old) => fs::write(&out, old).unwrap(),
                None => fs::remove_file(&out).unwrap(),
            }
            // With more threads, blocks of the image come in any order, and so the number of calls differs from run to run.
            let mut command = sandbox.command(&merge);
            command.env("RAYON_NUM_THREADS", "1");
            if !kill_before(command, kills + 1) {
                break;
            }
            kills += 1;
            let bytes = fs::read(&out).ok();
            let is_old = bytes.as_deref() == old.map(str::as_bytes);
            assert!(is_old || bytes.as_deref() == Some(&complete), "call {kills}");
            replaced += usize::from(!is_old);
            left += usize::from(sandbox.files().iter().any(|name| name.ends_with(".part")));
            // What it removes is not counted.
            sandbox.run(&merge).exits(0);
            assert_eq!(sandbox.files(), ["0..8.exr", "8..16.exr", "out.exr"], "call {kills}");
        }
        assert!(kills > 10 && (1..kills).contains(&replaced), "{kills} kills, {replaced} behind the end");
        // Some file systems have no files without names.
        let nameless = File::options().write(true).custom_flags(libc::O_TMPFILE).open(sandbox.work());
        assert!(nameless.is_err() || old.is_some() || left == 0, "{left} of {kills} kills left a temporary file");
    }
}

// Pipes and devices

/// Were a checkpoint written to the pipe, its reader would have that one.
#[test]
fn a_pipe_gets_one_image_at_the_end() {
    let sandbox = Sandbox::new();
    let (pipe, copy) = (sandbox.at("pipe"), sandbox.at("copy"));
    make_pipe(&pipe);
    let arguments =
        [&sandbox.render_sphere(), ["-o", "pipe", "--spp", "8192", "--checkpoint", "1ms"].as_slice()].concat();
    let child = sandbox.command(&arguments).spawn().expect("the program starts");
    let reader = std::thread::spawn(move || fs::read(pipe).unwrap());
    finish(child).exits(0);
    fs::write(&copy, reader.join().unwrap()).unwrap();
    assert_eq!(attribute(&sandbox.exr("copy"), "gpu-rt:complete"), "1");
    assert_eq!(sandbox.files(), ["copy", "pipe"]);
}

#[test]
fn images_go_through_standard_output_and_into_devices() {
    let sandbox = Sandbox::new();
    let copy = sandbox.at("copy");
    let written = || read_exr(&copy).map(|image| (image.width, image.height)).unwrap();
    // Into a file behind what it has: here, nothing.
    for output in ["/dev/stdout", "/dev/fd/1"] {
        let arguments = [&sandbox.render_sphere()[..], &["-o", output, "--checkpoint", "1ms"]].concat();
        ran(sandbox.command(&arguments).stdout(File::create(&copy).unwrap())).exits(0);
        assert_eq!(written(), (20, 12));
    }
    // Into the pipe of a process.
    let line = "\"$0\" \"$@\" | cat > copy";
    let mut shell = std::process::Command::new("sh");
    let arguments = [&sandbox.render_sphere()[..], &["-o", "/dev/stdout"]].concat();
    shell.current_dir(sandbox.work()).args(["-c", line, env!("CARGO_BIN_EXE_gpu-rt")]).args(arguments);
    fs::remove_file(&copy).unwrap();
    assert!(shell.output().unwrap().status.success());
    assert_eq!(written(), (20, 12));
    sandbox.render(&["-o", "/dev/null", "--checkpoint", "1ms"]).exits(0);
    assert_eq!(sandbox.files(), ["copy"]);
    // The image is kept elsewhere, but not beside a device.
    if cfg!(target_os = "linux") {
        let (arguments, temporary) = (sandbox.render_sphere(), temporary(&sandbox));
        let mut command = sandbox.command(&[&arguments[..], &["-o", "/dev/full"]].concat());
        ran(command.env("TMPDIR", &temporary)).exits(1).says_last("error: /dev/full: cannot write: No space left");
        assert_eq!(names(&temporary), ["sphere.rescued.exr"]);
    }
}

/// What is asked for has not been delivered. (A reader who has read enough is no failure: `a_closed_stdout_is_no_failure`.)
#[cfg(target_os = "linux")]
#[test]
fn a_full_standard_output_is_an_error_of_every_command() {
    let sandbox = Sandbox::new();
    let full = || File::options().write(true).open("/dev/full").expect("it is there");
    let with = |line: &str, stdout: std::process::Stdio| {
        let line = line
            .replace("SPHERE", "../scenes/sphere.ron")
            .replace("render ", &format!("render --device {} ", software()));
        let mut command = sandbox.command(&words(&line));
        ran(command.env("OIDN_DIR", oidn::folder()).stdout(stdout))
    };
    with("render SPHERE --quiet --samples 0..8 -o a.exr", full().into()).exits(0);
    with("render SPHERE --quiet --samples 8..16 -o b.exr", full().into()).exits(0);
    let help = sandbox.run(&["--help"]).exits(0).stdout;
    let listed = help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    let listed = listed.filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    let names: Vec<&str> =
        listed.filter_map(|line| line.split_whitespace().next()).filter(|name| *name != "help").collect();
    let mut lines: Vec<String> = names.iter().map(|name| format!("{name} --help")).collect();
    lines.extend(["--help", "--version", "-V", "help", "help submit slurm"].map(str::to_owned));
    let reports = [
        "render SPHERE --spp 1 --quiet --json -o r.exr",
        "render SPHERE --spp 1 --quiet -o -",
        "render SPHERE --spp 1 --quiet -o /dev/stdout",
        "merge a.exr b.exr --quiet --json -o merged.exr",
        "develop a.exr -o -",
        "denoise a.exr --json -o denoised.exr",
        "submit slurm SPHERE --spp 16 --parts 2 --dry-run -o job",
        "status job",
        "status job --json",
        "compare a.exr b.exr",
        "compare a.exr b.exr --json",
        "converge SPHERE --reference b.exr --spp 2",
        "converge SPHERE --reference b.exr --spp 2 --json",
        "plan SPHERE",
        "plan SPHERE --json",
        "serve SPHERE",
        "check SPHERE",
        "check SPHERE --json",
        "devices",
        "devices --json",
        "completions bash",
        "man",
    ];
    lines.extend(reports.map(str::to_owned));
    for line in &lines {
        let _ = fs::remove_dir_all(sandbox.at("job"));
        if line.starts_with("status") {
            with("submit slurm SPHERE --spp 16 --parts 2 --dry-run -o job", std::process::Stdio::piped()).exits(0);
        }
        let ran = with(line, full().into()).exits(1);
        let is_said = ran.last_line().starts_with("error: ")
            && ran.last_line().contains(": cannot write: No space left on device");
        assert!(is_said, "{line}: {}", ran.stderr);
    }
    // What was rendered is there all the same.
    assert_eq!(attribute(&sandbox.exr("r.exr"), "gpu-rt:complete"), "1");
    // `view`, `page` and `convert` print nothing. A measurement takes long, unless it is interrupted.
    let missing = names.iter().filter(|name| !reports.iter().any(|line| line.split_whitespace().next() == Some(name)));
    assert_eq!(missing.collect::<Vec<_>>(), [&"tradeoff", &"view", &"page", &"convert"]);
    let arguments = ["tradeoff", "../scenes/sphere.ron", "--budget", "1h", "--device", software(), "-o", "report"];
    let mut child = sandbox.command(&arguments).stdout(full()).spawn().expect("the program starts");
    meanwhile(&mut child, || sandbox.at("report").exists());
    send(&child, libc::SIGTERM);
    finish(child).exits(1).on_stderr(&["stdout: cannot write: No space left"]);
    // Nobody asked for what is told on standard error.
    ran(sandbox.command(&sandbox.render_sphere()).stderr(full())).exits(0);
}

// While rendering

/// What a render has said so far; its stderr goes to the file `said`.
fn said(sandbox: &Sandbox) -> String {
    fs::read_to_string(sandbox.folder.path().join("said")).unwrap()
}

/// A render without end into a folder of its own, which has written its first checkpoint.
fn endless_in_folder(sandbox: &Sandbox, more: &[&str]) -> Child {
    fs::create_dir(sandbox.at("out")).unwrap();
    let arguments = ["--spp", ENDLESS, "--checkpoint", "50ms", "-o", "out/a.exr"];
    let mut command = sandbox.command(&[&sandbox.render_sphere(), &arguments[..], more].concat());
    command.stderr(File::create(sandbox.folder.path().join("said")).unwrap());
    let mut child = command.spawn().expect("the program starts");
    meanwhile(&mut child, || sandbox.at("out/a.exr").exists());
    child
}

#[test]
fn a_checkpoint_that_fails_is_reported_at_once_and_tried_again() {
    let sandbox = Sandbox::new();
    let mut child = endless_in_folder(&sandbox, &[]);
    fs::rename(sandbox.at("out"), sandbox.at("away")).unwrap();
    let says = "warning: no checkpoint: out/a.exr: cannot write: the folder out does not exist. The render goes on";
    meanwhile(&mut child, || said(&sandbox).contains(says));
    // Another reason is reported too.
    fs::create_dir_all(sandbox.at("other/a.exr")).unwrap();
    fs::rename(sandbox.at("other"), sandbox.at("out")).unwrap();
    meanwhile(&mut child, || {
        said(&sandbox).contains("warning: no checkpoint: out/a.exr: cannot write: it is a folder")
    });
    fs::remove_dir(sandbox.at("out/a.exr")).unwrap();
    meanwhile(&mut child, || {
        said(&sandbox).contains("the checkpoint is written again") && sandbox.at("out/a.exr").is_file()
    });
    // A file that is gone is written again, without a word.
    let words = said(&sandbox);
    fs::remove_file(sandbox.at("out/a.exr")).unwrap();
    meanwhile(&mut child, || sandbox.at("out/a.exr").is_file());
    send(&child, libc::SIGTERM);
    finish(child).exits(143);
    assert!(!said(&sandbox)[words.len()..].contains("tries again"), "{}", said(&sandbox));
    assert_eq!(attribute(&read_exr(&sandbox.at("out/a.exr")).unwrap(), "gpu-rt:complete"), "0");
}

/// A limit of a file's size stands for a full disk: it can be set and lifted while the program runs.
#[cfg(target_os = "linux")]
#[test]
fn on_a_full_disk_the_last_checkpoint_stays() {
    let sandbox = Sandbox::new();
    let file = sandbox.at("out/a.exr");
    let mut child = endless_in_folder(&sandbox, &["--size", "64x64"]);
    let number = child.id() as i32;
    let limit = |bytes: u64| {
        let limit = libc::rlimit { rlim_cur: bytes, rlim_max: libc::RLIM_INFINITY };
        // SAFETY: the structure is read during the call, and the child has not been waited for.
        let set = unsafe { libc::prlimit(number, libc::RLIMIT_FSIZE, &limit, std::ptr::null_mut()) };
        assert_eq!(set, 0, "the limit is set");
    };
    limit(16 << 10);
    meanwhile(&mut child, || {
        said(&sandbox).contains("warning: no checkpoint: out/a.exr: cannot write: File too large")
    });
    let before = fs::read(&file).unwrap();
    assert!(before.len() > 16 << 10);
    read_exr(&file).expect("the last checkpoint is whole");
    limit(libc::RLIM_INFINITY);
    meanwhile(&mut child, || said(&sandbox).contains("the checkpoint is written again"));
    assert!(fs::read(&file).unwrap() != before);
    send(&child, libc::SIGINT);
    finish(child).exits(130);
    assert_eq!(fs::read_dir(sandbox.at("out")).unwrap().count(), 1, "nothing else is left");
}

/// A folder for temporary files of its own.
fn temporary(sandbox: &Sandbox) -> PathBuf {
    let folder = sandbox.folder.path().join("temporary");
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// What happens to the folder of an image while it is rendered.
enum Fate {
    Stays,
    IsMoved,
    IsGone,
    IsFolder,
    Reserved,
}

/// The image goes to another name: in its folder, or in that of temporary files. The error has the command that goes on with it.
#[cfg(target_os = "linux")]
#[test]
fn an_image_without_its_place_goes_to_another_name() {
    let sandbox = Sandbox::new();
    sandbox.render(&["--quiet", "--spp", "32", "-o", "full.exr"]).exits(0);
    let (full, temporary) = (Held::read(&sandbox.at("full.exr")), temporary(&sandbox));
    let out = sandbox.at("out");
    for (fate, output, rescued) in [
        (Fate::Stays, "out/a b.exr", None),
        (Fate::IsMoved, "out/a b.exr", Some("../temporary/a-b.rescued.exr")),
        (Fate::IsGone, "out/a b.exr", Some("../temporary/a-b.rescued.exr")),
        (Fate::IsFolder, "out/a b.exr", Some("out/a-b.rescued.exr")),
        (Fate::Reserved, "out/a b.exr", Some("out/a-b.rescued-2.exr")),
        (Fate::IsGone, "out/a.png", Some("../temporary/a.rescued.exr")),
    ] {
        let _ = fs::remove_dir_all(&out);
        fs::create_dir(&out).unwrap();
        let arguments = ["render", "../scenes/sphere.ron", "--device", software(), "-o", output, "--force"];
        let mut command = sandbox.command(&arguments);
        command.env("MESA_SHADER_CACHE_DISABLE", "true").env("TMPDIR", "../temporary");
        let mut child = command.spawn().expect("the program starts");
        until_listening(&mut child);
        match fate {
            Fate::Stays => {}
            Fate::IsMoved => fs::rename(&out, sandbox.at("away")).unwrap(),
            Fate::IsGone => fs::remove_dir_all(&out).unwrap(),
            Fate::IsFolder | Fate::Reserved => fs::create_dir(out.join("a b.exr")).unwrap(),
        }
        if matches!(fate, Fate::Reserved) {
            fs::write(out.join("a-b.rescued.exr"), "another").unwrap();
        }
        let ran = finish(child).exits(i32::from(rescued.is_some()));
        let Some(rescued) = rescued else {
            assert_eq!(names(&out), ["a b.exr"]);
            assert_eq!(names(&temporary), [""; 0]);
            continue;
        };
        let says = format!("; {rescued} holds 16 samples per pixel. `gpu-rt ");
        let (error, command) = ran.last_line().split_once(&says).unwrap_or_else(|| panic!("{}", ran.stderr));
        assert!(error.starts_with(&format!("error: {output}: cannot write: ")), "{error}");
        let command = command.strip_suffix("` goes on").expect("a command");
        sandbox.says(&format!("{command} --quiet --spp 32")).exits(0);
        assert_eq!(Held::read(&sandbox.at(rescued)).difference(&full), [""; 0]);
        fs::remove_file(sandbox.at(rescued)).unwrap();
        assert_eq!(names(&temporary), [""; 0]);
        if matches!(fate, Fate::Reserved) {
            assert_eq!(fs::read_to_string(out.join("a-b.rescued.exr")).unwrap(), "another");
        }
    }
}

/// The image is there, and the picture can be made of it.
#[cfg(target_os = "linux")]
#[test]
fn a_picture_without_its_place_can_be_made_later() {
    let sandbox = Sandbox::new();
    let out = sandbox.at("out");
    fs::create_dir(&out).unwrap();
    let arguments = [&sandbox.render_sphere()[..], &["-o", "a.exr", "--png", "out/a.png"]].concat();
    let mut child = sandbox.command(&arguments).env("MESA_SHADER_CACHE_DISABLE", "true").spawn().expect("it starts");
    until_listening(&mut child);
    fs::remove_dir(&out).unwrap();
    let ran = finish(child).exits(1);
    let says = "out/a.png: cannot write: the folder out does not exist; a.exr holds the image. `gpu-rt develop a.exr -o NAME.png`";
    assert!(ran.last_line().contains(says), "{}", ran.stderr);
    sandbox.says("develop a.exr -o NAME.png").exits(0);
    assert_eq!(sandbox.files(), ["NAME.png", "a.exr"]);
}

/// A disk that is full from the start is reported before the first checkpoint, which is an hour away. At the end the image goes to the folder of
/// temporary files, if that has room, and its own name is tried again: for a while, or until a signal comes if no folder has room.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_told_at_the_start_and_tried_again_at_the_end() {
    for (is_all_full, is_freed, status) in [(false, false, 1), (false, true, 0), (true, false, 143), (true, true, 0)] {
        let sandbox = Sandbox::new();
        let (temporary, full) = (temporary(&sandbox), sandbox.folder.path().join("full"));
        let mut command =
            sandbox.command(&[&sandbox.render_sphere()[..], &["-o", "a.exr", "--checkpoint", "1h"]].concat());
        let disk = if is_all_full { sandbox.folder.path().to_owned() } else { sandbox.work() };
        on_full_disk(&mut command, &disk, &full);
        // What it says is on another disk.
        let said = tempfile::NamedTempFile::new().unwrap();
        let words = || fs::read_to_string(said.path()).unwrap();
        fs::write(&full, "").unwrap();
        let mut child =
            command.env("TMPDIR", &temporary).stderr(said.reopen().unwrap()).spawn().expect("the program starts");
        let until =
            if is_all_full { "a.exr is tried again until it can be written or" } else { "a.exr is tried again\n" };
        meanwhile(&mut child, || words().contains(until));
        let at_start =
            words().lines().position(|line| line.starts_with("warning: no checkpoint: a.exr: cannot write: "));
        let at_end = words().lines().position(|line| line.starts_with("warning: a.exr: cannot write: No space left"));
        assert!(at_start.is_some() && at_start < at_end, "{}", words());
        assert_eq!(sandbox.files(), [""; 0]);
        assert_eq!(names(&temporary).is_empty(), is_all_full);
        if is_freed {
            fs::remove_file(&full).unwrap();
        } else if is_all_full {
            send(&child, libc::SIGTERM);
        }
        finish(child).exits(status);
        let last = words().lines().last().unwrap_or_default().to_owned();
        if is_freed {
            assert!(words().contains("a.exr is written after all\n"), "{}", words());
            assert_eq!(attribute(&sandbox.exr("a.exr"), "gpu-rt:complete"), "1");
            assert!(names(&temporary).is_empty());
        } else if is_all_full {
            let says = "error: interrupted by SIGTERM; a.exr: cannot write: No space left on device (os error 28); the image cannot be written elsewhere";
            assert!(last.starts_with(says), "{last}");
        } else {
            let rescued = temporary.join("a.rescued.exr");
            let says = format!("; {} holds 16 samples per pixel. `gpu-rt render ", rescued.display());
            assert!(last.starts_with("error: a.exr: cannot write: No space left") && last.contains(&says), "{last}");
            assert_eq!(attribute(&read_exr(&rescued).unwrap(), "gpu-rt:complete"), "1");
        }
    }
    let ran = Sandbox::new().render(&[]).exits(0);
    assert!(!ran.stderr.contains("cannot write"), "{}", ran.stderr);
}

#[test]
fn a_replaced_image_keeps_its_mode() {
    let sandbox = Sandbox::new();
    let file = sandbox.at("sphere.exr");
    sandbox.render(&[]).exits(0);
    let mode = |path: &Path| fs::metadata(path).unwrap().mode() & 0o7777;
    fs::write(sandbox.at("plain"), "").unwrap();
    assert_eq!(mode(&file), mode(&sandbox.at("plain")), "a new one has the mode of any new file");
    fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).unwrap();
    let child = endless(&sandbox, &[]);
    send(&child, libc::SIGINT);
    finish(child).exits(130);
    assert_eq!(mode(&file), 0o640);
}

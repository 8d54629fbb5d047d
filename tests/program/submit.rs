//! One render shared among many processes: what is given to Slurm, and what its tasks come to. A fake Slurm takes the jobs; the tests run
//! their scripts. `make test-slurm` does it with a real one.

use std::fs;
use std::io::ErrorKind;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use gpu_rt::output::exr::read_state;
use tempfile::TempDir;

use super::resume::{Held, SCENE, save_floor};
use crate::common::device::index as software;
use crate::common::program::{Ran, command, finish, meanwhile, ran, run, send, with_signals, words};

/// Takes a job: keeps its arguments, each on a line, and says its number.
const SBATCH: &str =
    "n=$(($(ls \"$fake\" | grep -c '^job') + 1))\nprintf '%s\\n' \"$@\" >\"$fake/job$n\"\necho $((40 + n))\n";
/// Reports the limit and the state of jobs, and keeps what is to start again.
const SCONTROL: &str = "case $1 in
show) case $2 in config) echo \"MaxArraySize = $(cat \"$fake/most\")\" ;; job) cat \"$fake/state\" ;; esac ;;
requeue) echo \"$2\" >>\"$fake/requeued\" ;;
esac
";

/// A folder with a scene, and a cluster that takes jobs and runs none.
struct Cluster {
    folder: TempDir,
}

impl Cluster {
    fn new() -> Cluster {
        let cluster = Cluster { folder: tempfile::tempdir().expect("a temporary folder") };
        for name in ["bin", "fake", "spool", "it's a \"scene\"/in", "it's a \"scene\"/images"] {
            fs::create_dir_all(cluster.path(name)).expect("a folder is made");
        }
        fs::write(cluster.scene(), SCENE.replace("floor.png", "../images/floor.png")).expect("the scene is written");
        save_floor(&cluster.path("it's a \"scene\"/images/floor.png"));
        cluster.write("fake/most", "1001");
        cluster.write("fake/state", "JobState=RUNNING");
        let fake = cluster.path("fake");
        let fake = |text: &str| format!("#!/bin/sh\nfake='{}'\n{text}", fake.display());
        cluster.program("bin/sbatch", &fake(SBATCH));
        cluster.program("bin/scontrol", &fake(SCONTROL));
        cluster
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn scene(&self) -> PathBuf {
        self.path("it's a \"scene\"/in/a $scene.ron")
    }

    /// The folder of the job, and the names that it has there.
    fn job(&self, name: &str) -> PathBuf {
        self.path("the job's").join(name)
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).expect("the file is written");
    }

    fn program(&self, name: &str, text: &str) {
        self.write(name, text);
        fs::set_permissions(self.path(name), fs::Permissions::from_mode(0o755)).expect("it can be run");
    }

    /// Has a command find the cluster's programs before others.
    fn here(&self, command: &mut Command) {
        let path = std::env::var_os("PATH").unwrap_or_default();
        let folders = std::iter::once(self.path("bin")).chain(std::env::split_paths(&path));
        command.env("PATH", std::env::join_paths(folders).expect("no folder has a colon"));
        let set = "SLURM_JOB_ID SLURM_ARRAY_JOB_ID SLURM_ARRAY_TASK_ID SLURM_JOB_GPUS CUDA_VISIBLE_DEVICES GPU_RT";
        for name in set.split(' ') {
            command.env_remove(name);
        }
    }

    /// `submit slurm` with these words, and its answers for the new folder.
    fn submit(&self, more: &str) -> Ran {
        let scene = self.scene();
        let job = self.job("");
        let device = software().to_string();
        let mut words = vec![scene.to_str().expect("UTF-8"), "-o", job.to_str().expect("UTF-8"), "--device", &device];
        words.extend(more.split_whitespace());
        self.slurm(&words)
    }

    fn slurm(&self, words: &[&str]) -> Ran {
        let mut command = command(self.folder.path(), &[&["submit", "slurm"], words].concat());
        self.here(&mut command);
        ran(&mut command)
    }

    /// Submits the folder that is there again.
    fn again(&self, option: &str) -> Ran {
        self.slurm(&[option, self.job("").to_str().expect("UTF-8")])
    }

    /// The arguments of the jobs that have been submitted since the last question.
    fn jobs(&self) -> Vec<Vec<String>> {
        let mut jobs = Vec::new();
        for number in 1.. {
            let file = self.path(&format!("fake/job{number}"));
            let Ok(text) = fs::read_to_string(&file) else { break };
            if !text.is_empty() {
                jobs.push(text.lines().map(str::to_string).collect());
                fs::write(&file, "").expect("it is emptied");
            }
        }
        jobs
    }

    /// Starts a script as Slurm does: a copy that lies elsewhere.
    fn start(&self, script: &str, task: Option<u32>, set: &dyn Fn(&mut Command)) -> Child {
        let copy = self.path(&format!("spool/{}-{script}", task.map_or(String::new(), |task| task.to_string())));
        fs::copy(self.job(script), &copy).expect("it is copied");
        let mut command = Command::new(copy);
        command.current_dir(self.path("spool")).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        with_signals(&mut command, libc::SIG_DFL);
        self.here(&mut command);
        command.env("SLURM_JOB_ID", "41");
        if let Some(task) = task {
            command.env("SLURM_ARRAY_JOB_ID", "41").env("SLURM_ARRAY_TASK_ID", task.to_string());
        }
        set(&mut command);
        loop {
            // Another thread may be between fork and exec, with the copy open for writing.
            match command.spawn() {
                Err(error) if error.kind() == ErrorKind::ExecutableFileBusy => std::thread::yield_now(),
                started => return started.expect("the script starts"),
            }
        }
    }

    fn task(&self, task: u32) -> Ran {
        finish(self.start("render.sh", Some(task), &|_| {}))
    }

    fn merge(&self) -> Ran {
        finish(self.start("merge.sh", None, &|_| {}))
    }

    /// Renders with one process what the folder is to have together.
    fn full(&self, more: &str) -> Held {
        let scene = self.scene();
        let device = software().to_string();
        let mut words =
            vec!["render", scene.to_str().expect("UTF-8"), "--device", &device, "--quiet", "--force", "-o", "full.exr"];
        words.extend(more.split_whitespace());
        run(self.folder.path(), &words).exits(0);
        Held::read(&self.path("full.exr"))
    }

    fn requeued(&self) -> String {
        fs::read_to_string(self.path("fake/requeued")).unwrap_or_default()
    }
}

/// The tasks that an array lists.
fn listed(job: &[String]) -> Vec<u32> {
    let list = job.iter().find_map(|word| word.strip_prefix("--array=")).expect("it is an array");
    let number = |text: &str| text.parse::<u32>().expect("a number");
    let range = |word: &str| match word.split_once('-') {
        Some((from, to)) => number(from)..number(to) + 1,
        None => number(word)..number(word) + 1,
    };
    list.split(',').flat_map(range).collect()
}

fn has(job: &[String], word: &str) -> bool {
    job.iter().any(|known| known == word)
}

/// Tasks, a part that is missing, the one task that renders it, and the join: the bytes of one render, of the scene as it was when it was
/// submitted.
#[test]
fn a_submitted_render_has_the_bytes_of_one() {
    let cluster = Cluster::new();
    let full = cluster.full("--spp 100 --roulette off");
    let said = ["parts: 4 of 4, 100 samples, in 4 tasks", "disk: 153.6 kB", "array: 41", "merge: 42"];
    cluster.submit("--spp 100 --parts 4 --roulette off -- --partition=long --time=2:00:00").exits(0).on_stdout(&said);
    fs::write(cluster.scene(), "what comes later").expect("it is written");
    let jobs = cluster.jobs();
    let [array, merge] = &jobs[..] else { panic!("{jobs:?}") };
    for word in
        ["--array=0-3", "--signal=B:TERM@120", "--requeue", "--open-mode=append", "--partition=long", "--time=2:00:00"]
    {
        assert!(has(array, word), "{word}: {array:?}");
    }
    assert!(has(merge, "--dependency=afterany:41") && has(merge, "--partition=long"), "{merge:?}");
    assert_eq!(array.last(), cluster.job("render.sh").to_str().map(str::to_string).as_ref());

    [0, 1, 3].into_iter().for_each(|task| _ = cluster.task(task).exits(0));
    assert_eq!(cluster.task(4).code(), 2, "there is no such task");
    cluster.merge().exits(2).on_stderr(&["gap: no part has the samples 48..72 after parts/024-048.exr"]);
    assert!(!cluster.job("a $scene.exr").exists());

    cluster.again("--missing").exits(0);
    let jobs = cluster.jobs();
    let [array, merge] = &jobs[..] else { panic!("{jobs:?}") };
    assert!(
        has(array, "--array=2") && has(array, "--partition=long") && has(merge, "--dependency=afterany:43"),
        "{jobs:?}"
    );
    cluster.task(2).exits(0);
    cluster.merge().exits(0);
    assert_eq!(Held::read(&cluster.job("a $scene.exr")).difference(&full), [""; 0]);

    // With nothing missing, the join alone is submitted.
    cluster.again("--missing").exits(0);
    let jobs = cluster.jobs();
    assert!(jobs.len() == 1 && !jobs[0].iter().any(|word| word.starts_with("--dependency")), "{jobs:?}");
    // A part that is damaged is not taken for one that is missing.
    fs::write(cluster.job("parts/024-048.exr"), "no image").expect("it is written");
    cluster.again("--missing").exits(2).on_stderr(&["parts/024-048.exr: cannot read"]);
}

/// A task that a lost node has left running, and the one that Slurm has started instead.
#[test]
fn two_that_write_one_part_do_no_harm() {
    let cluster = Cluster::new();
    cluster.submit("--spp 64 --parts 1 --checkpoint 0.001").exits(0);
    let both = [0, 0].map(|task| cluster.start("render.sh", Some(task), &|_| {}));
    both.into_iter().for_each(|task| _ = finish(task).exits(0));
    cluster.merge().exits(0);
    assert_eq!(Held::read(&cluster.job("a $scene.exr")).difference(&cluster.full("--spp 64")), [""; 0]);
}

/// SIGTERM to the script, as Slurm sends it before the time is over: the part is kept, the task requests a restart, and goes on.
#[test]
fn a_task_that_is_ended_starts_again_and_goes_on() {
    let cluster = Cluster::new();
    cluster.submit("--spp 1000000000 --parts 1 --checkpoint 0.01").exits(0);
    let part = cluster.job("parts/0000000000-1000000000.exr");
    let held = || {
        if part.exists() { read_state(&part).expect("it is read").expect("it has a state").samples.count() } else { 0 }
    };
    let mut before = 0;
    for tries in 1..=2 {
        let mut script = cluster.start("render.sh", Some(0), &|_| {});
        meanwhile(&mut script, || held() > before);
        let then = held();
        send(&script, libc::SIGTERM);
        finish(script).exits(143).on_stderr(&["interrupted by SIGTERM"]);
        assert!(held() >= then, "{} samples after {then}", held());
        before = held();
        assert_eq!(cluster.requeued(), "41_0\n".repeat(tries));
    }
    let one = cluster.full(&format!("--spp {before}"));
    assert!(Held::read(&part).film == one.film, "it went on with what was there");
}

/// Which endings start a task again, and how often.
#[test]
fn a_task_starts_again_five_times_at_most() {
    let cluster = Cluster::new();
    cluster.submit("--spp 64 --parts 2").exits(0);
    let ends_with = |status: u32| {
        cluster.program("bin/ends", &format!("#!/bin/sh\nexit {status}\n"));
        let script = cluster.start("render.sh", Some(1), &|command| _ = command.env("GPU_RT", "ends"));
        assert_eq!(finish(script).code(), status as i32);
        cluster.requeued().lines().count()
    };
    assert_eq!(ends_with(2), 0, "what is wrong stays so");
    cluster.write("fake/state", "JobState=COMPLETING Reason=None");
    assert_eq!(ends_with(143), 0, "what is cancelled stays so");
    cluster.write("fake/state", "JobState=RUNNING");
    let tries: Vec<usize> = (0..7).map(|_| ends_with(137)).collect();
    assert_eq!(tries, [1, 2, 3, 4, 5, 5, 5]);
    // What succeeds, or is submitted anew, has all tries again.
    assert_eq!([ends_with(0), ends_with(137)], [5, 6]);
    (0..6).for_each(|_| _ = ends_with(137));
    cluster.again("--missing").exits(0);
    assert_eq!([ends_with(137), ends_with(137)], [11, 12]);
}

/// When a task requests a restart, its program has ended: Slurm would kill what it is about to write.
#[test]
fn a_task_waits_for_its_program() {
    let cluster = Cluster::new();
    cluster.submit("--spp 64 --parts 1").exits(0);
    for (status, after) in [(143, "ended\n41_0\n"), (0, "ended\n")] {
        let _ = fs::remove_file(cluster.path("fake/requeued"));
        let [begun, requeued] = ["fake/begun", "fake/requeued"].map(|name| cluster.path(name));
        cluster.program(
            "bin/slow",
            &format!(
                "#!/bin/sh\ntrap 'sleep 0.5; echo ended >>\"{}\"; exit {status}' TERM\n>\"{}\"\nwhile :; do sleep 0.01; done\n",
                requeued.display(),
                begun.display()
            ),
        );
        let mut script = cluster.start("render.sh", Some(0), &|command| _ = command.env("GPU_RT", "slow"));
        meanwhile(&mut script, || begun.exists());
        send(&script, libc::SIGTERM);
        assert_eq!(finish(script).code(), status);
        assert_eq!(cluster.requeued(), after);
        fs::remove_file(begun).expect("it was there");
    }
}

/// Rounds of tasks until an error is reached: the bytes of `render --noise`.
#[test]
fn rounds_end_where_one_render_would() {
    let cluster = Cluster::new();
    for (options, rounds, said) in [("--noise 0.08", 2, "is reached"), ("--noise 0.001 --spp 40", 3, "is not reached")]
    {
        cluster.submit(&format!("{options} --parts 2")).exits(0);
        let (mut count, mut last) = (0, String::new());
        loop {
            let jobs = cluster.jobs();
            let [array, _] = &jobs[..] else { break };
            listed(array).into_iter().for_each(|task| _ = cluster.task(task).exits(0));
            last = cluster.merge().exits(0).stdout;
            count += 1;
        }
        assert!(count >= rounds && last.contains(said), "{options}: {count} rounds; {last}");
        let full = cluster.full(options);
        assert_eq!(Held::read(&cluster.job("a $scene.exr")).difference(&full), [""; 0], "{options}");

        // Without Slurm the join says what comes next; here nothing does. Asked again, it is the same.
        let again = cluster.again("--next").exits(0);
        assert!(again.stdout.contains(said) && cluster.jobs().is_empty(), "{}", again.stdout);
        // A larger error ends the join at an earlier check, whatever parts there are.
        let (parts, out) = (cluster.job("parts"), cluster.path("less.exr"));
        let [parts, out] = [&parts, &out].map(|path| path.to_str().expect("UTF-8"));
        run(cluster.folder.path(), &["merge", "--quiet", "--noise", "0.3", parts, "-o", out]).exits(0);
        assert_eq!(Held::read(Path::new(out)).difference(&cluster.full("--noise 0.3")), [""; 0]);
        fs::remove_dir_all(cluster.job("")).expect("it was there");
    }
    // The next round waits for the join of this one.
    cluster.submit("--noise 0.001 --parts 2").exits(0);
    cluster.again("--next").exits(2).on_stderr(&["a $scene.exr is not there"]);
    listed(&cluster.jobs()[0]).into_iter().for_each(|task| _ = cluster.task(task).exits(0));
    cluster.merge().exits(0);
    cluster.again("--next").exits(2).on_stderr(&["has 16 of 32 samples"]);
}

/// More parts than an array may have tasks: each renders several.
#[test]
fn the_largest_array_of_the_cluster_is_kept() {
    let cluster = Cluster::new();
    cluster.write("fake/most", "3");
    cluster.submit("--spp 64 --parts 8").exits(0);
    assert_eq!(listed(&cluster.jobs()[0]), [0, 1, 2]);
    [0, 2].into_iter().for_each(|task| _ = cluster.task(task).exits(0));
    cluster.again("--missing").exits(0);
    assert_eq!(listed(&cluster.jobs()[0]), [1]);
    cluster.merge().exits(2).on_stderr(&["no part has the samples 8..16, 32..40, 56..64"]);
    cluster.task(1).exits(0);
    cluster.merge().exits(0);
    assert_eq!(Held::read(&cluster.job("a $scene.exr")).difference(&cluster.full("--spp 64")), [""; 0]);
}

/// What cannot be submitted leaves nothing behind, and says why.
#[test]
fn a_refused_submission_leaves_nothing_behind() {
    let cluster = Cluster::new();
    let refused = |more: &str, words: &[&str]| {
        cluster.submit(more).exits(2).on_stderr(words);
        assert!(!cluster.job("").exists() && cluster.jobs().is_empty(), "{more}");
    };
    refused("--spp 64 --parts 9", &["64 samples are 8 runs of 8", "--parts 8 at most"]);
    refused("--spp 64 --parts 0", &["--parts"]);
    refused("--spp 64", &["--parts"]);
    refused("--missing x", &["cannot be used with"]);
    for more in ["--integrator bsdf", "--size 8x8", "--seed 3", "--max-depth 3", "--spp 8", "--noise 0.1", "--next x"] {
        cluster.slurm(&words(&format!("--missing x {more}"))).exits(2).on_stderr(&["cannot be used with"]);
    }
    cluster.slurm(&["--missing", "fake"]).exits(2).on_stderr(&["fake/job.json: cannot read", "submit"]);

    // Without Slurm, and with --dry-run.
    fs::remove_file(cluster.path("bin/sbatch")).expect("it was there");
    fs::remove_file(cluster.path("bin/scontrol")).expect("it was there");
    let only_here = |more: &[&str]| {
        let scene = cluster.scene();
        let job = cluster.job("");
        let (scene, job) = (scene.to_str().expect("UTF-8"), job.to_str().expect("UTF-8"));
        let fixed = ["submit", "slurm", scene, "--spp", "64", "--parts", "2", "-o", job];
        let mut command = command(cluster.folder.path(), &[&fixed, more].concat());
        ran(command.env("PATH", cluster.path("bin")))
    };
    only_here(&[]).exits(1).on_stderr(&["sbatch", "--dry-run"]);
    assert!(!cluster.job("").exists());
    let by_parallel = "seq 0 1 | parallel -j 1 ./render.sh && ./merge.sh";
    let by_slurm = ["sbatch '--job-name=a $scene'", "--array=0-1"];
    only_here(&["--dry-run"]).exits(0).on_stdout(&by_slurm).on_stdout(&[by_parallel]);
    only_here(&["--dry-run"]).exits(2).on_stderr(&["it is not empty"]);
    let next = cluster.slurm(&["--dry-run", "--next", cluster.job("").to_str().expect("UTF-8")]);
    next.exits(2).on_stderr(&["without --noise"]);
    // The folder runs where it lies, by a loop or GNU parallel.
    for words in [vec!["render.sh", "0"], vec!["render.sh", "1"], vec!["merge.sh"]] {
        let mut command = Command::new(cluster.job(words[0]));
        command.args(&words[1..]).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        cluster.here(&mut command);
        finish(command.spawn().expect("the script starts")).exits(0);
    }
    assert_eq!(Held::read(&cluster.job("a $scene.exr")).samples, "0..64");
}

/// A GPU for each task: Vulkan knows it by its address alone.
#[test]
fn each_task_takes_its_gpu() {
    let cluster = Cluster::new();
    let (scene, job) = (cluster.scene(), cluster.job(""));
    let [scene, job] = [&scene, &job].map(|path| path.to_str().expect("UTF-8"));
    let submit = |more: &[&str]| {
        let _ = fs::remove_dir_all(job);
        cluster.slurm(&[&[scene, "--spp", "64", "--parts", "2", "-o", job], more].concat()).exits(0);
    };
    cluster.program("bin/says", "#!/bin/sh\necho \"$@\"\n");
    cluster.program("bin/nvidia-smi", "#!/bin/sh\n[ \"$1\" = --id=3 ] && echo 00000000:3B:00.0\n");
    let says = |gpus: Option<&'static str>| {
        let set = |command: &mut Command| {
            command.env("GPU_RT", "says");
            gpus.map(|gpus| command.env("SLURM_JOB_GPUS", gpus));
        };
        finish(cluster.start("render.sh", Some(0), &set)).exits(0).stdout
    };
    submit(&[]);
    assert!(says(Some("3")).contains("--device 0000:3b:00.0"));
    assert!(says(Some("3,4")).contains("--device 0000:3b:00.0"));
    assert!(!says(Some("0")).contains("--device"), "Slurm hides all but the own one");
    assert!(!says(None).contains("--device"));
    submit(&["--device", "the o'ther"]);
    assert!(says(Some("3")).contains("--device the o'ther"));
}

/// A file that a scene names by its absolute path stays where it is, as a note says.
#[test]
fn absolute_paths_stay() {
    let cluster = Cluster::new();
    let texture = cluster.path("it's a \"scene\"/images/floor.png");
    let absolute_path = texture.to_str().expect("UTF-8").replace('"', "\\\"");
    fs::write(cluster.scene(), SCENE.replace("floor.png", &absolute_path)).expect("the scene is written");
    cluster.submit("--spp 16 --parts 1").exits(0).on_stdout(&["not copied", "images/floor.png"]);
    assert!(cluster.job("scene/a $scene.ron").exists() && !cluster.job("scene/images").exists());
    cluster.task(0).exits(0);
}

/// `merge --samples` takes exactly these, and `merge --noise` parts that end where it checks the error.
#[test]
fn a_join_has_the_requested_samples() {
    let cluster = Cluster::new();
    cluster.submit("--spp 48 --parts 2").exits(0);
    [0, 1].into_iter().for_each(|task| _ = cluster.task(task).exits(0));
    let (parts, out) = (cluster.job("parts"), cluster.path("out.exr"));
    let [parts, out] = [&parts, &out].map(|path| path.to_str().expect("UTF-8"));
    let merge = |more: &[&str]| run(cluster.folder.path(), &[&["merge", "--quiet", parts, "-o", out], more].concat());
    for (options, words) in [
        ("0..56", "gap: no part has the samples 48..56"),
        ("0..40", "24-48.exr: it has the samples 24..48, beyond --samples 0..40"),
        ("8..48", "00-24.exr: it has the samples 0..24, beyond --samples 8..48"),
    ] {
        merge(&["--samples", options]).exits(2).on_stderr(&[words]);
    }
    merge(&["--noise", "0.001"]).exits(2).on_stderr(&["00-24.exr: --noise checks the error at 16 samples"]);
    assert!(!Path::new(out).exists());
    merge(&["--samples", "0..48"]).exits(0);
    assert_eq!(Held::read(Path::new(out)).difference(&cluster.full("--spp 48")), [""; 0]);
}

//! The pace of `gpu-rt serve`.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::Stdio;
use std::time::Instant;

use serde_json::{Value, json};

use crate::alone;
use crate::common::device::index as software;
use crate::common::program::{command, finish};

/// The share of the time of a process for each image that an image of a session may take. Measured: 0.05 of 0.23 s on two cores that nobody else uses,
/// 0.16 where two others use them, and 0.4 beside a suite of tests, which slows what computes more than what starts. One that compiles its kernels
/// takes as long as a process.
const MOST: f64 = 0.6;

/// Once a session has begun, an image takes a small part of the time of a process for it. From the same place, with another seed, no kernel is linked, and
/// no buffer made; other channels need both.
#[test]
fn an_image_of_a_session_takes_a_small_part_of_a_process() {
    let _alone = alone();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/weekend.ron").display().to_string();
    let settings = ["--size", "64x64", "--spp", "1", "--device", software()];
    let process = || {
        let begin = Instant::now();
        let words = ["render", &scene, "-o", "a.exr", "--force"];
        finish(command(folder.path(), &[&words, &settings[..]].concat()).spawn().expect("it starts")).exits(0);
        begin.elapsed().as_secs_f64()
    };
    // The driver's cache then has the kernels.
    process();
    let of_process = (0..3).map(|_| process()).fold(f64::INFINITY, f64::min);

    let mut serve = command(folder.path(), &[&["serve", &scene, "--quiet"], &settings[..]].concat());
    let mut child = serve.stdin(Stdio::piped()).spawn().expect("it starts");
    let mut requests = child.stdin.take().expect("a pipe");
    let mut answers = BufReader::new(child.stdout.take().expect("a pipe")).lines();
    answers.next().expect("it opens").expect("a line");
    let mut image = |number: i32, aov: &str| {
        let camera = format!("(look_from: ({}, {}, 3))", 13 - number % 9, 2 + number % 5);
        writeln!(requests, "{}", json!({"output": "b.exr", "camera": camera, "seed": number, "aov": aov}))
            .expect("it reads");
        let answer = answers.next().expect("it answers").expect("a line");
        let answer: Value = serde_json::from_str(&answer).expect("JSON");
        assert_eq!(answer["error"], Value::Null);
        answer["report"]["seconds"]["compile"].as_f64().expect("seconds")
    };
    // Those of all places are compiled once.
    (0..45).for_each(|number| _ = image(number, "depth"));
    // The least of three, as of processes: others use the cores at times.
    let mut some = |first: i32| {
        let begin = Instant::now();
        (first..first + 15).for_each(|number| _ = image(number, "depth"));
        begin.elapsed().as_secs_f64() / 15.0
    };
    let of_session = [0, 15, 30].map(&mut some).into_iter().fold(f64::INFINITY, f64::min);
    assert!((1..5).all(|round| image(44 + 45 * round, "depth") == 0.0));
    assert!(image(44, "normal") > 0.0);
    let share = of_session / of_process;
    assert!(share < MOST, "{of_session} s and {of_process} s");
    drop(requests);
    finish(child).exits(0);
}

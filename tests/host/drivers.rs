//! What tests/drivers/matrix.sh makes of the logs of cargo test: a failure is a fault unless it is known, and a known one that is gone
//! is a fault too.

use std::fs;
use std::process::Command;

const KNOWN: &str =
    "# A comment | of | no use\nslow | walk::deep | allows 10\nother | walk::wide | of another driver\n";

/// A log of two binaries, the second with a test `deep` that ended so.
fn log(deep: &str) -> String {
    let (verdict, message) = match deep {
        "" => ("ok", String::new()),
        message => {
            ("FAILED", format!("\nfailures:\n\n---- deep stdout ----\n\nthread 'deep' panicked:\n{message}\n\n"))
        }
    };
    format!(
        "    Finished `release` profile\n     Running tests/cli.rs (target/cli-0)\n\nrunning 1 test\ntest help ... ok\n\
         test result: ok. 1 passed\n     Running tests/walk/main.rs (target/walk-0)\n\nrunning 2 tests\ntest wide ... ok\n\
         test deep ... {verdict}\n{message}test result: whatever\n"
    )
}

/// The matrix's lines and faults, and whether all is well.
fn judge(driver: &str, log: &str) -> (String, bool) {
    let sandbox = tempfile::tempdir().expect("a temporary folder");
    let [known, written] = ["known.txt", "log"].map(|name| sandbox.path().join(name));
    fs::write(&known, KNOWN).expect("it is written");
    fs::write(&written, log).expect("it is written");
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/drivers/matrix.sh");
    let mut command = Command::new("bash");
    let run = command.args([script, "judge", driver]).arg(&written).env("KNOWN_FAILURES", &known).output();
    let run = run.expect("bash runs");
    assert!(run.stderr.is_empty(), "{}", String::from_utf8_lossy(&run.stderr));
    (String::from_utf8(run.stdout).expect("it is text"), run.status.success())
}

#[test]
fn known_failures_are_no_faults_and_all_else_is() {
    let all_well = "fast\tcli\t1 passed\nfast\twalk\t2 passed\n";
    assert_eq!(judge("fast", &log("")), (all_well.to_string(), true));
    let (text, well) = judge("slow", &log("the device allows 10 a stage"));
    assert!(well && text.ends_with("slow\twalk\t1 passed, 1 known\n"), "{text}");
    for (driver, deep, fault) in [
        ("fast", "allows 10", "fault: fast: walk::deep fails:"),
        ("slow", "something else", "fault: slow: walk::deep fails with other words than \"allows 10\":"),
        ("slow", "", "fault: slow: walk::deep passes: take it out"),
    ] {
        let (text, well) = judge(driver, &log(deep));
        assert!(!well && text.contains(fault) && text.contains(deep), "{text}");
    }
    // What has not run is no success: a test that is gone, a binary that has died, a build that has failed.
    let (text, well) = judge("other", &log("").replace("wide", "narrow"));
    assert!(!well && text.contains("fault: other: walk::wide is known to fail and was not run"), "{text}");
    let (text, well) = judge("fast", &log("").replace("test result: whatever\n", ""));
    assert!(!well && text.contains("fault: fast: walk died") && text.contains("DIED"), "{text}");
    let (text, well) = judge("fast", "error: could not compile\n");
    assert!(!well && text.contains("fault: fast: cargo test ran nothing"), "{text}");
}

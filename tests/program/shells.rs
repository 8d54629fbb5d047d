//! The completions of shells and the manual page.

use std::fs;
use std::process::Command;

use crate::common::program::run;
use crate::sandbox::Sandbox;

#[test]
fn shells_complete_commands_and_options() {
    let sandbox = Sandbox::new();
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        // Some are longer than a pipe holds.
        let script = run(&sandbox.work(), &["completions", shell]).exits(0).stdout;
        for word in ["gpu-rt", "tradeoff", "max-depth", "independent"] {
            assert!(script.contains(word), "{shell}: {word}");
        }
    }
    let script = sandbox.at("gpu-rt.bash");
    fs::write(&script, run(&sandbox.work(), &["completions", "bash"]).exits(0).stdout).expect("it is written");
    // What the shell does at a tab: it calls the function that is registered for the program.
    let complete = "set -- $(complete -p gpu-rt); while [ \"$1\" != -F ]; do shift; done; \
        COMP_WORDS=(gpu-rt tra); COMP_CWORD=1; $2 gpu-rt tra gpu-rt; echo \"${COMPREPLY[@]}\"";
    let found = Command::new("bash").args(["-c", &format!("source \"$0\" && {complete}")]).arg(&script).output();
    assert_eq!(String::from_utf8_lossy(&found.expect("bash runs").stdout), "tradeoff\n");
    sandbox.run(&["completions", "tcsh"]).exits(2).on_stderr(&["possible values: bash"]);
}

#[test]
fn every_command_has_a_manual_page() {
    let sandbox = Sandbox::new();
    let page = sandbox.run(&["man"]).exits(0).stdout;
    assert!(page.contains(".TH gpu-rt 1") && page.contains("tradeoff"), "{page}");
    sandbox.run(&["man", "pages/man1"]).exits(0);
    let read = |name: &str| fs::read_to_string(sandbox.at(format!("pages/man1/{name}.1"))).unwrap_or_default();
    assert_eq!(read("gpu-rt"), page);
    // Every command that help lists, and no other.
    let help = sandbox.run(&["--help"]).exits(0).stdout;
    let listed = help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    let listed: Vec<&str> = listed.filter(|line| line.starts_with("  ") && !line.starts_with("   ")).collect();
    let names: Vec<&str> =
        listed.iter().filter_map(|line| line.split_whitespace().next()).filter(|name| *name != "help").collect();
    assert!(names.contains(&"render") && names.len() >= 10, "{names:?}");
    assert!(names.iter().all(|name| read(&format!("gpu-rt-{name}")).contains(".SH SYNOPSIS")), "{names:?}");
    assert!(read("gpu-rt-render").contains("max\\-depth") && read("gpu-rt-submit-slurm").contains(".SH OPTIONS"));
    let pages = fs::read_dir(sandbox.at("pages/man1")).expect("a folder").count();
    assert_eq!(pages, 1 + names.len() + 1, "the program, its commands, and `submit slurm`");
}

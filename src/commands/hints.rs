//! Hints about command lines that are wrong: what others call an option, and a scene without a command.

use std::path::Path;

use clap::builder::StyledStr;
use clap::error::{ContextKind, ContextValue, ErrorKind};

/// Names of options in other programs, and here.
const OTHER_NAMES: &[(&[&str], &str)] = &[
    (&["--width", "--height", "--resolution", "--res", "-w"], "--size"),
    (&["-s", "-n", "-N", "--samples-per-pixel", "--sample-count", "--num-samples", "--quality"], "--spp"),
    (&["--gpu", "--cpu", "--backend"], "--device"),
    (&["--out", "--out-file", "--image"], "--output"),
    (&["--depth", "--bounces", "--max-bounces"], "--max-depth"),
    (&["--timeout", "--seconds", "-t"], "--time"),
    (&["--error", "--threshold", "--noise-threshold"], "--noise"),
    (&["--continue"], "--resume"),
    (&["--overwrite", "-y"], "--force"),
    (&["-q"], "--quiet"),
    (&["-v"], "--verbose"),
];

/// The error with what was meant, where that is known.
pub fn with_hint(mut error: clap::Error) -> clap::Error {
    let given = |kind| match error.get(kind) {
        Some(ContextValue::String(given)) => Some(given.clone()),
        _ => None,
    };
    match error.kind() {
        ErrorKind::UnknownArgument => {
            let Some(given) = given(ContextKind::InvalidArg) else { return error };
            let name = given.split('=').next().unwrap_or_default();
            if let Some((_, meant)) = OTHER_NAMES.iter().find(|(others, _)| others.contains(&name)) {
                // clap's tip about values that begin with a hyphen would be wrong here.
                error.remove(ContextKind::Suggested);
                // So would its usage, which has what clap took for the option.
                error.remove(ContextKind::Usage);
                error.insert(ContextKind::SuggestedArg, ContextValue::String((*meant).to_string()));
            }
        }
        ErrorKind::InvalidSubcommand => {
            let Some(given) = given(ContextKind::InvalidSubcommand) else { return error };
            if let Some(tip) = command_for(&given) {
                error.remove(ContextKind::SuggestedSubcommand);
                error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![StyledStr::from(tip)]));
            }
        }
        _ => {}
    }
    error
}

/// What to do with a file that stands where a command is expected.
fn command_for(given: &str) -> Option<String> {
    match Path::new(given).extension()?.to_str()?.to_ascii_lowercase().as_str() {
        "ron" | "glb" | "gltf" => Some(format!("to render a scene, write 'gpu-rt render {given}'")),
        "exr" => Some(format!("to make a picture of it, write 'gpu-rt develop {given} -o FILE.png'")),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_without_a_command_have_one() {
        assert!(command_for("a/s.ron").is_some_and(|tip| tip.contains("gpu-rt render a/s.ron")));
        assert!(command_for("b.EXR").is_some_and(|tip| tip.contains("develop")));
        assert_eq!(command_for("frobnicate"), None);
    }
}

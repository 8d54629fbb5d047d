//! What commands print: reports on standard output, and everything else on standard error.

use std::io::Write;
use std::path::Path;

use serde_json::{Map, Value};

use crate::cluster::scripts::line;
use crate::error::{Error, Result};
use crate::output::exr::ExrImage;
use crate::output::stdout;
use crate::printable::printable;
pub use crate::terminal::tell;
use crate::terminal::{columns_of_stdout, fit_to_terminal};

/// Prints an error, each of its messages on a line of its own.
pub fn tell_error(error: &Error) {
    error.messages().iter().for_each(|message| tell(&format!("error: {message}")));
}

/// The command line as it was typed, as the shell reads it. The folder of the program is left out.
pub fn command_line() -> String {
    line(&words_of_command())
}

/// The command line of a render that goes on with what this file holds.
pub fn command_to_resume(image: &Path) -> String {
    line(&words_to_resume(words_of_command(), path_text(image)))
}

/// The command line that makes another file, such as `NAME.png`, of an image.
pub fn command_of_image(command: &str, image: &Path, output: &str) -> String {
    line(&["gpu-rt", command, &path_text(image), "-o", output].map(str::to_string))
}

fn words_of_command() -> Vec<String> {
    let words = std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned());
    std::iter::once("gpu-rt".to_string()).chain(words).collect()
}

/// The words of `gpu-rt render` with another output and --resume, and without what --resume takes no part in.
fn words_to_resume(words: Vec<String>, image: String) -> Vec<String> {
    // Of a sequence the name has no frame's number, and stays.
    let is_sequence = words.iter().any(|word| word == "--frames" || word.starts_with("--frames="));
    let mut words = words.into_iter();
    let mut kept = Vec::new();
    while let Some(word) = words.next() {
        let (name, value) = word.split_once('=').map_or((&*word, None), |(name, value)| (name, Some(value)));
        match name {
            "--resume" | "--watch" | "--force" => {}
            _ if is_sequence => kept.push(word),
            "-o" | "--output" => _ = value.is_none().then(|| words.next()),
            _ if name.starts_with("-o") => {}
            _ => kept.push(word),
        }
    }
    if !is_sequence {
        kept.extend(["-o".to_string(), image]);
    }
    kept.push("--resume".to_string());
    kept
}

/// Tells where the colours of an image with which errors are measured were converted, and warns if it is denoised: errors of its pixels are then
/// not independent.
pub fn tell_measured(path: &Path, image: &ExrImage) {
    if let Some(denoiser) = image.denoiser() {
        let name = path.display();
        tell(&format!(
            "warning: {name} is denoised ({denoiser}): it is biased, and its pixels share errors, so that intervals are too narrow"
        ));
    }
    tell_colours(path, image.colours.as_deref());
}

/// Tells where the colours of an image were converted.
pub fn tell_colours(path: &Path, colours: Option<&str>) {
    if let Some(words) = colours {
        tell(&format!("{}: {words}", path.display()));
    }
}

/// A path as text for JSON.
pub fn path_text(path: &Path) -> String {
    path.display().to_string()
}

/// Prints one JSON object on stdout. No line of it is broken.
pub fn print_json(object: &Value) -> Result<()> {
    write_stdout(&format!("{}\n", printable(&format!("{object:#}"))))
}

pub fn print_line(text: &str) -> Result<()> {
    print_text(&format!("{text}\n"))
}

/// Prints text on stdout as a terminal shows it, without an additional line end.
pub fn print_text(text: &str) -> Result<()> {
    write_stdout(&fit_to_terminal(text, columns_of_stdout()))
}

/// Writes on stdout. A closed pipe is not an error, because the reader chose to close it.
pub fn write_stdout(text: &str) -> Result<()> {
    flushed(std::io::stdout().write_all(text.as_bytes()))
}

/// Prints the help or the version that the command line asks for, with colours on a terminal.
pub fn print_help(help: &clap::Error) -> Result<()> {
    flushed(help.print())
}

/// What has come of writing on stdout, once all of it is written.
fn flushed(written: std::io::Result<()>) -> Result<()> {
    use std::io::ErrorKind;
    match written.and_then(|()| std::io::stdout().flush()).and_then(|()| stdout::check()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Error::file("stdout", "write")(error)),
        _ => Ok(()),
    }
}

/// The entries of a JSON object.
pub fn object(value: Value) -> Map<String, Value> {
    match value {
        Value::Object(entries) => entries,
        _ => Map::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::words_to_resume;

    #[test]
    fn a_command_goes_on_with_another_file() {
        let resumes = |words: &str| {
            words_to_resume(words.split(' ').map(str::to_string).collect(), "b.exr".to_string()).join(" ")
        };
        for output in ["-o a.exr ", "-oa.exr ", "-o=a.exr ", "--output a.exr ", "--output=a.exr ", ""] {
            for others in ["", "--resume=auto ", "--watch --force "] {
                let words = format!("gpu-rt render {output}s.ron {others}--spp=8");
                assert_eq!(resumes(&words), "gpu-rt render s.ron --spp=8 -o b.exr --resume", "{words}");
            }
        }
        let words = "gpu-rt render s.glb --frames 1..9 -o a.##.exr --resume=auto";
        assert_eq!(resumes(words), "gpu-rt render s.glb --frames 1..9 -o a.##.exr --resume");
    }
}

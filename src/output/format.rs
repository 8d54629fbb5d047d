//! The format of an image's file, which its name says.

use std::path::Path;

use super::destination::{Destination, is_standard};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    Exr,
    Png,
}

impl Format {
    /// Its ending, and its name.
    fn names(self) -> (&'static str, &'static str) {
        match self {
            Format::Exr => ("exr", "an EXR"),
            Format::Png => ("png", "a PNG"),
        }
    }
}

/// The format that the name of an output says: by its ending, and `-` is a PNG on standard output. Pipes, devices and open files such as
/// /dev/stdout may have any name; without an ending that is known they get the first of the formats.
///
/// # Errors
/// Why the name is none of one of these formats, and a name that is.
pub fn format_of(path: &Path, formats: &[Format]) -> Result<Format, String> {
    let names = || {
        let name = |format: &Format| path.with_extension(format.names().0).display().to_string();
        formats.iter().map(name).collect::<Vec<_>>().join(" or ")
    };
    let wanted = || formats.iter().map(|format| format.names().1).collect::<Vec<_>>().join(" or ");
    if is_standard(path) {
        return match formats.contains(&Format::Png) {
            true => Ok(Format::Png),
            false => Err(format!("standard output gets a PNG, and this is {}: give the name of a file", wanted())),
        };
    }
    let ending = path.extension().map(|ending| ending.to_string_lossy());
    let known = [Format::Exr, Format::Png];
    let named =
        known.into_iter().find(|format| ending.as_ref().is_some_and(|e| e.eq_ignore_ascii_case(format.names().0)));
    match (named, &ending) {
        (Some(named), _) if formats.contains(&named) => Ok(named),
        (Some(_), _) => Err(format!("this is {}: give {}", wanted(), names())),
        (None, _) if matches!(Destination::find(path), Ok(Destination::Stream)) => {
            formats.first().copied().ok_or_else(|| "no image is written".to_string())
        }
        (None, Some(ending)) => Err(format!(".{ending} is not written, only {}: give {}", wanted(), names())),
        (None, None) => Err(format!("a name without an ending says no format: give {}", names())),
    }
}

#[cfg(test)]
mod tests {
    use super::{Format, format_of};
    use std::path::Path;

    #[test]
    fn names_say_formats() {
        use Format::{Exr, Png};
        let both = &[Exr, Png][..];
        let of = |name: &str, formats: &[Format]| format_of(Path::new(name), formats);
        for (name, formats, format) in [
            ("a.exr", both, Exr),
            ("a.EXR", both, Exr),
            ("sub.png/a.exr", both, Exr),
            ("a.png", both, Png),
            ("a.exr.PNG", both, Png),
            ("-", both, Png),
            ("-", &[Png], Png),
            ("/dev/null", both, Exr),
            ("/dev/null", &[Png], Png),
        ] {
            assert_eq!(of(name, formats), Ok(format), "{name} {formats:?}");
        }
        for (name, formats, words) in [
            ("a.jpg", both, ".jpg is not written, only an EXR or a PNG: give a.exr or a.png"),
            ("a.jpg", &[Png], ".jpg is not written, only a PNG: give a.png"),
            ("a", both, "a name without an ending says no format: give a.exr or a.png"),
            (".exr", both, "a name without an ending says no format: give .exr.exr or .exr.png"),
            ("a.png", &[Exr], "this is an EXR: give a.exr"),
            ("a.exr", &[Png], "this is a PNG: give a.png"),
            ("-", &[Exr], "standard output gets a PNG, and this is an EXR: give the name of a file"),
        ] {
            assert_eq!(of(name, formats), Err(words.to_owned()), "{name} {formats:?}");
        }
    }
}

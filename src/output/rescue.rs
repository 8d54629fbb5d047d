//! Another name for an image that cannot be written under its own.

use std::fs::{self, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};

use super::destination::{Destination, folder_of};

/// The longest part of a name that is kept, in bytes.
const LONGEST: usize = 100;
/// How many names are tried in a folder.
const NAMES: usize = 100;

/// The folders to write an image to instead of `path`: its own, and that of temporary files. Beside a pipe or a device there is no
/// place for a file.
pub fn folders(path: &Path) -> Vec<PathBuf> {
    let own = match Destination::find(path) {
        Ok(Destination::Stream) => None,
        Ok(Destination::File(target)) => Some(folder_of(&target).to_owned()),
        Err(_) => Some(folder_of(path).to_owned()),
    };
    own.into_iter().chain([std::env::temp_dir()]).collect()
}

/// Makes an empty file in the folder, of a name that nothing has: NAME.rescued.exr, or with a number. A name has letters, digits, dots and
/// hyphens alone, and does not begin with a hyphen. Nobody may read the file who may not read that at `like`.
pub fn reserve(folder: &Path, name: &Path, like: &Path) -> io::Result<PathBuf> {
    let old = fs::metadata(like).ok().filter(fs::Metadata::is_file);
    let mut options = OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, if old.is_some() { 0o600 } else { 0o666 });
    let stem = plain_stem(name);
    let mut taken = io::Error::from(io::ErrorKind::AlreadyExists);
    for number in 1..=NAMES {
        let number = if number == 1 { String::new() } else { format!("-{number}") };
        let path = folder.join(format!("{stem}.rescued{number}.exr"));
        match options.open(&path) {
            Ok(file) => {
                if let Some(old) = old {
                    let _ = file.set_permissions(old.permissions());
                }
                return Ok(path);
            }
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => taken = error,
            Err(error) => return Err(error),
        }
    }
    Err(taken)
}

/// A file's name without its ending, in letters, digits, dots and hyphens.
fn plain_stem(name: &Path) -> String {
    let stem = name.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let plain = stem.chars().map(|c| if c.is_ascii_alphanumeric() || c == '.' { c } else { '-' });
    let plain: String = plain.skip_while(|c| !c.is_ascii_alphanumeric()).take(LONGEST).collect();
    if plain.is_empty() { "image".to_owned() } else { plain }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_plain() {
        for (name, stem) in [
            ("out/still-life.exr", "still-life"),
            ("a b_c.v2.exr", "a-b-c.v2"),
            ("-o.png", "o"),
            ("Küche.exr", "K-che"),
            ("場景.exr", "image"),
            ("..", "image"),
        ] {
            assert_eq!(plain_stem(Path::new(name)), stem, "{name}");
        }
        assert_eq!(plain_stem(&PathBuf::from("n".repeat(250))).len(), LONGEST);
    }

    /// Nothing that is there is taken, nor what a link of the name points to.
    #[cfg(unix)]
    #[test]
    fn a_name_that_is_taken_stays() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("a.rescued.exr"), "old").unwrap();
        symlink("elsewhere", at("a.rescued-2.exr")).unwrap();
        fs::create_dir(at("a.rescued-3.exr")).unwrap();
        let reserved = |like: &str| reserve(folder.path(), Path::new("a.exr"), &at(like)).unwrap();
        assert_eq!(reserved("missing"), at("a.rescued-4.exr"));
        assert_eq!(fs::read_to_string(at("a.rescued.exr")).unwrap(), "old");
        assert!(!at("elsewhere").exists());
        // What was kept from others is still.
        fs::set_permissions(at("a.rescued.exr"), fs::Permissions::from_mode(0o640)).unwrap();
        let secret = reserved("a.rescued.exr");
        assert_eq!(fs::metadata(secret).unwrap().permissions().mode() & 0o777, 0o640);
        assert!(reserve(&at("missing"), Path::new("a.exr"), &at("a.exr")).is_err());
    }

    #[test]
    fn a_stream_has_no_file_beside_it() {
        let temporary = std::env::temp_dir();
        assert_eq!(folders(Path::new("-")), std::slice::from_ref(&temporary));
        assert_eq!(folders(Path::new("out/a.exr")), [PathBuf::from("out"), temporary]);
    }
}

//! Files of the repository.

use std::path::{Path, PathBuf};

/// The files in a folder that end so, sorted; those of its folders, too, where it is `deep`. The folder may be named from the repository's.
pub fn files(folder: impl AsRef<Path>, ending: &str, deep: bool) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let entries = std::fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let of = |path: PathBuf| match path.is_dir() {
        true if deep => files(path, ending, deep),
        is_folder => {
            if !is_folder && path.to_string_lossy().ends_with(ending) {
                vec![path]
            } else {
                Vec::new()
            }
        }
    };
    let mut found: Vec<PathBuf> = entries.flat_map(|entry| of(entry.expect("it can be listed").path())).collect();
    found.sort();
    found
}

/// The name of a file without its ending.
pub fn stem(path: &Path) -> String {
    path.file_stem().expect("a name").to_string_lossy().into_owned()
}

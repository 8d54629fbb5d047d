//! What a driver gets of a plan, as hashes: the kernels' texts, bindings and overrides, the state of paths, and the sizes of buffers. A change that
//! only moves code between files changes none of them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use gpu_rt::gpu::buffers::BufferSpec;
use gpu_rt::gpu::layout;
use gpu_rt::plan::{Kernel, Kernels};

/// What is named differently since the tables were written: the name today, and the name in the tables. A name of today that a table has for
/// something else would hide a change, so [`hash`] refuses texts with the old one.
const RENAMES: [(&str, &str); 0] = [];

/// FNV-1a (Fowler, Noll, Vo) of 32 bits.
fn hash(text: &str) -> String {
    let mut text = text.to_string();
    for (new, old) in RENAMES {
        assert!(words(&text).all(|word| word != old), "{old} is called {new} now");
        text = renamed(&text, new, old);
    }
    let step = |hash: u32, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193);
    format!("{:08x}", text.bytes().fold(0x811c_9dc5_u32, step))
}

fn is_of_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c| !is_of_word(c))
}

/// The text with a word in place of another.
pub fn renamed(text: &str, from: &str, to: &str) -> String {
    let mut rest = text;
    let mut out = String::new();
    while let Some(at) = rest.find(from) {
        let (before, after) = (&rest[..at], &rest[at + from.len()..]);
        let is_word = !before.ends_with(is_of_word) && !after.starts_with(is_of_word);
        out += before;
        out += if is_word { to } else { from };
        rest = after;
    }
    out + rest
}

/// A kernel's text in its order, without comments, as the driver gets it, and what it binds and leaves open.
pub fn hash_of_kernel(kernel: &Kernel) -> String {
    let (bindings, overrides) = (&kernel.bindings, layout::overrides(&kernel.module));
    hash(&format!("{}\n{bindings:?}\n{overrides:?}", kernel.linked.text))
}

/// The hashes of a plan: of each kernel by name, and of the state of paths.
pub fn hashes(kernels: &Kernels) -> Vec<String> {
    let own = kernels.all().into_iter().map(|kernel| format!("{}={}", kernel.name, hash_of_kernel(kernel)));
    let fields = kernels.path_fields.iter();
    let fields: Vec<String> =
        fields.map(|field| format!("{} {} {:?} {:?}", field.name, field.words, field.w_of, field.code)).collect();
    own.chain([format!("path={}", hash(&fields.join("\n")))]).collect()
}

/// The hash of the sizes of buffers.
pub fn hash_of_buffers(buffers: &[BufferSpec<'_>]) -> String {
    let each: Vec<String> =
        buffers.iter().map(|spec| format!("{} {} {:?}", spec.name, spec.bytes, spec.usage)).collect();
    format!("buffers={}", hash(&each.join("\n")))
}

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/plans").join(format!("{name}.tsv"))
}

/// Holds rows against a table of tests/plans; `GPU_RT_RENEW=1` writes it anew. Returns the rows that differ or are missing on either side.
pub fn differences(table: &str, rows: &BTreeMap<String, Vec<String>>) -> Vec<String> {
    let path = file(table);
    if super::renew() {
        let lines: String = rows.iter().map(|(key, hashes)| format!("{key}\t{}\n", hashes.join(" "))).collect();
        std::fs::write(&path, lines).expect("the table is written");
    }
    let text = std::fs::read_to_string(&path).expect("the table is read");
    let known: BTreeMap<&str, Vec<&str>> = text
        .lines()
        .filter_map(|line| line.split_once('\t'))
        .map(|(key, hashes)| (key, hashes.split(' ').collect()))
        .collect();
    let changed = rows.iter().filter(|(key, hashes)| known.get(key.as_str()).is_none_or(|old| old != *hashes)).map(
        |(key, hashes)| {
            let old = known.get(key.as_str()).cloned().unwrap_or_default();
            let new: Vec<&str> = hashes.iter().map(String::as_str).filter(|hash| !old.contains(hash)).collect();
            format!("{key}: {}", new.join(" "))
        },
    );
    let missing = known.keys().filter(|key| !rows.contains_key(**key)).map(|key| format!("{key}: no more"));
    changed.chain(missing).collect()
}

//! Images stay the same to the last bit. The hashes under tests/unchanged, one file per driver, were recorded before the code was
//! rearranged. The test uses the command line alone, so that it does not depend on that code.
//!
//! It renders the scenes that ship, the references, files by Blender, and what all of these lack (tests/unchanged/rest.ron), with the default
//! settings and with others, linked in every way and in dispatches of several sizes. All channels of the EXR count, and the state beside them.
//! On a driver without a table it compares the ways of linking with each other, which make the same bytes. `GPU_RT_RENEW_HASHES=1` writes the
//! table: do this only where images are meant to change. Names in place of the 1, such as `scenes/window,scenes/mesh`, renew those scenes alone.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use exr::prelude::{ReadChannels, ReadLayers, read};
use gpu_rt::output::exr::{ExrImage, read_exr};
use serde_json::Value;

#[path = "unchanged/scenes.rs"]
mod of_unchanged;
use of_unchanged::scenes;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
const SCATTERS: [&str; 3] = ["fused", "linked", "queues"];
/// Of stages that are kernels of their own.
const SMALL_DISPATCHES: [&str; 6] = ["--slots", "1000", "--workgroup", "32", "--bounces", "3"];
/// The counts of a report: whatever is neither a time nor a word about the machine.
const COUNTS: &str = "paths rays rejected_samples cut_paths cut_throughput relative_error relative_error_bound reliable \
                      light_stopped_by_glass light_met_through_glass";

/// The sets of options by name: the defaults, and options that link other modules. That kernels with all features make the same bytes is a test of
/// tests/images/features.rs.
const SETS: [(&str, &[&str]); 3] = [
    ("default", &[]),
    ("rough", &["--aov", CHANNELS, "--aov-surface", "rough", "--filter", "mitchell", "--clamp", "1"]),
    ("first", &["--aov", CHANNELS, "--aov-surface", "first", "--fresnel", "schlick", "--integrator", "bsdf"]),
];
const CHANNELS: &str = "albedo,normal,depth,position,object,material,direct,indirect";

/// An image with all its channels, the counts beside it, and the driver's name.
struct Rendered {
    image: ExrImage,
    /// The bits of all channels of all parts of the file, by name.
    channels: BTreeMap<String, Vec<u32>>,
    counts: String,
    driver: String,
}

fn render(scene: &Path, scatter: &str, options: &[&str]) -> Rendered {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = folder.path().join("image.exr");
    let mut command = Command::new(env!("CARGO_BIN_EXE_gpu-rt"));
    command.arg("render").arg(scene).arg("-o").arg(&output);
    command.args(["--size", "64x36", "--spp", "16", "--json", "--quiet", "--scatter", scatter]).args(options);
    command.args(SMALL_DISPATCHES.iter().filter(|_| scatter != "fused"));
    // A software device, unless the tests are to run on another.
    let device = std::env::var("GPU_RT_TEST_DEVICE").unwrap_or_else(|_| "llvmpipe".to_string());
    let ran = command.args(["--device", &device]).output().expect("the program starts");
    assert!(ran.status.success(), "{}: {}", scene.display(), String::from_utf8_lossy(&ran.stderr));
    let report: Value = serde_json::from_slice(&ran.stdout).expect("a report");
    let counts = COUNTS.split(' ').map(|name| {
        let count = report.get(name).unwrap_or_else(|| panic!("the report has no {name}"));
        format!("{name} {count}\n")
    });
    let image = read_exr(&output).expect("the image is read");
    let (counts, driver) = (counts.collect(), report["driver"].as_str().expect("a name").to_string());
    Rendered { image, channels: channels(&output), counts, driver }
}

fn channels(file: &Path) -> BTreeMap<String, Vec<u32>> {
    let all = read().no_deep_data().largest_resolution_level().all_channels().all_layers().all_attributes();
    let parts = all.non_parallel().from_file(file).expect("all parts are read").layer_data;
    let mut channels = BTreeMap::new();
    for part in &parts {
        let name = part.attributes.layer_name.clone().unwrap_or_default();
        for channel in &part.channel_data.list {
            let bits = channel.sample_data.values_as_f32().map(f32::to_bits);
            channels.insert(format!("{name} {}", channel.name), bits.collect());
        }
    }
    channels
}

impl Rendered {
    /// FNV-1a (Fowler, Noll, Vo) of 64 bits, over the bits of all channels and the counts.
    fn hash(&self) -> String {
        let ExrImage { width, height, rgb, variance, samples, rejected, .. } = &self.image;
        let floats = rgb.iter().chain(variance.as_ref().expect("variances")).flatten().map(|v| v.to_bits());
        let counts = [samples, rejected].into_iter().flat_map(|all| all.iter().flatten());
        let words = [*width, *height].into_iter().chain(floats).chain(counts.copied());
        let named = |(name, bits): (&String, &Vec<u32>)| {
            name.bytes().chain(bits.iter().flat_map(|word| word.to_le_bytes())).collect::<Vec<u8>>()
        };
        let bytes = words.flat_map(u32::to_le_bytes).chain(self.counts.bytes());
        let bytes = bytes.chain(self.channels.iter().flat_map(named));
        let hash = bytes
            .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3));
        format!("{hash:016x}")
    }
}

/// The options of a set for a scene. `--integrator bsdf` refuses lights without size.
fn options(name: &str, set: &str) -> Vec<&'static str> {
    let (_, options) = SETS.into_iter().find(|(own, _)| *own == set).expect("a set");
    let refused = name.starts_with("tests/blender") || name == "scenes/window";
    options.iter().map(|word| if refused && *word == "bsdf" { "mis" } else { word }).collect()
}

/// The file of a driver's hashes, without what a distribution adds to its version: `llvmpipe-mesa-22.3.6.txt`.
fn table_of(driver: &str) -> PathBuf {
    let version = driver.split(" (").next().unwrap_or(driver);
    let version = version.rsplit_once('-').map_or(version, |(version, _)| version);
    let name = version.to_lowercase().replace(' ', "-");
    Path::new(ROOT).join("tests/unchanged").join(format!("{name}.txt"))
}

/// Renders all scenes with a set of options in some ways, two at a time, and holds the hashes against the driver's table. Without a table, and for
/// a new one, the images are made in all ways.
fn check(set: &str, scatters: &[&'static str]) {
    let renewed = std::env::var("GPU_RT_RENEW_HASHES").ok();
    let renew = renewed.is_some();
    let driver = render(&Path::new(ROOT).join("scenes/cornell.ron"), "fused", &[]).driver;
    let has_table = !renew && !read_table(&table_of(&driver)).is_empty();
    let scatters = if has_table { scatters } else { &SCATTERS };
    let is_due = |name: &str| renewed.as_ref().is_none_or(|all| all == "1" || all.split(',').any(|own| own == name));
    let scenes: Vec<_> = scenes().into_iter().filter(|(name, _)| is_due(name)).collect();
    let (next, found) = (AtomicUsize::new(0), Mutex::new(BTreeMap::new()));
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                while let Some((name, path)) = scenes.get(next.fetch_add(1, Relaxed)) {
                    let rendered = |scatter: &&'static str| (*scatter, render(path, scatter, &options(name, set)));
                    let all: Vec<_> = scatters.iter().map(rendered).collect();
                    for (scatter, rendered) in &all {
                        let same = rendered.channels == all[0].1.channels;
                        assert!(same, "{name}: --scatter {scatter}, {set}, differs from {}", all[0].0);
                        let mut found = found.lock().expect("no thread has failed");
                        let hash = (rendered.hash(), table_of(&rendered.driver));
                        assert!(
                            found.insert(format!("{name} {set}"), hash.clone()).is_none_or(|other| other == hash),
                            "{name}, {set}: the counts differ"
                        );
                    }
                }
            });
        }
    });
    let found = found.into_inner().expect("no thread has failed");
    let (_, path) = found.values().next().expect("a scene").clone();
    let mut table = read_table(&path);
    if renew {
        table.extend(found.into_iter().map(|(key, (hash, _))| (key, hash)));
        let lines = table.iter().map(|(key, hash)| format!("{hash} {key}\n"));
        std::fs::write(&path, lines.collect::<String>()).expect("the table is written");
    } else if table.is_empty() {
        eprintln!("no table at {}: the ways of linking were held against each other alone", path.display());
    } else {
        let changed: Vec<_> = found.iter().filter(|(key, (hash, _))| table.get(*key) != Some(hash)).collect();
        assert!(changed.is_empty(), "these images changed: {changed:#?}");
    }
}

/// A driver's hashes; none where it has no table.
fn read_table(path: &Path) -> BTreeMap<String, String> {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    let line = |line: &str| line.split_once(' ').map(|(hash, key)| (key.to_string(), hash.to_string()));
    text.lines().filter_map(line).collect()
}

/// Each scene is linked in each way once, with options of its own: all ways have one hash in the table.
#[test]
fn images_are_what_they_were() {
    check("default", &["fused"]);
    check("rough", &["linked"]);
    check("first", &["queues"]);
}

#[test]
#[ignore = "minutes: make test-long"]
fn images_are_what_they_were_in_all_ways() {
    SETS.iter().for_each(|(set, _)| check(set, &SCATTERS));
}

/// Every table has a row for each scene and each set of options. A table is compared only with its driver, so a missing row would go unnoticed for
/// long.
#[test]
fn tables_have_every_scene_and_set() {
    let keys = |name: &String| SETS.map(|(set, _)| format!("{name} {set}"));
    let all: BTreeSet<String> = scenes().keys().flat_map(keys).collect();
    let files = std::fs::read_dir(Path::new(ROOT).join("tests/unchanged")).expect("the folder of tables");
    let paths = files.map(|file| file.expect("a file").path());
    let tables: Vec<_> = paths.filter(|path| path.extension().is_some_and(|ending| ending == "txt")).collect();
    assert_eq!(tables.len(), 2);
    for path in tables {
        let found: BTreeSet<String> = read_table(&path).into_keys().collect();
        let wrong: Vec<_> = all.symmetric_difference(&found).collect();
        assert!(wrong.is_empty(), "{}: rows that are missing or of no scene: {wrong:#?}", path.display());
    }
}

/// One material's red by one ulp of f32, or one pixel by one: another hash.
#[test]
fn a_change_of_one_ulp_is_found() {
    let path = Path::new(ROOT).join("scenes/cornell.ron");
    let rendered = render(&path, "fused", &[]);
    let hash = rendered.hash();
    let text = std::fs::read_to_string(&path).expect("the scene is read");
    let white = "Rgb(0.73, 0.73, 0.73)";
    assert!(text.contains(white));
    let folder = tempfile::tempdir().expect("a temporary folder");
    let moved = folder.path().join("cornell.ron");
    let red = f64::from(0.73_f32.next_up());
    std::fs::write(&moved, text.replacen(white, &format!("Rgb({red}, 0.73, 0.73)"), 1)).expect("a scene is written");
    assert_ne!(hash, render(&moved, "fused", &[]).hash(), "an albedo");
    let mut planted = render(&path, "fused", &[]);
    assert_eq!(hash, planted.hash(), "rendered again");
    let value = &mut planted.image.rgb[1000][1];
    *value = value.next_up();
    assert_ne!(hash, planted.hash(), "a pixel");
    // And one of a channel beside the radiance.
    let mut planted = render(&path, "fused", &options("scenes/cornell", "rough"));
    let hash = planted.hash();
    let channel = planted.channels.keys().find(|name| name.ends_with("albedo.G")).expect("the albedo").clone();
    planted.channels.get_mut(&channel).expect("it is there")[1000] += 1;
    assert_ne!(hash, planted.hash(), "an albedo of the image");
}

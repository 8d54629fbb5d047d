//! The files of tests/corpus/vdb, of which make.py there says the values, changed copies of them, and frames of blosc made here.

use std::collections::HashMap;
use std::io::Read;
use std::path::Path;
use std::time::{Duration, Instant};

use glam::{DAffine3, DMat4, DVec3, IVec3, ivec3};

use super::packed::Coding;
use super::{Input, map, read};
use crate::volume::grid::{Grid, Leaf, Tile};

const MOST: usize = 1 << 20;

fn file(name: &str) -> Vec<u8> {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/corpus/vdb")).join(name);
    let bytes = std::fs::read(&path).unwrap();
    if !name.ends_with(".gz") {
        return bytes;
    }
    let mut unpacked = Vec::new();
    flate2::read::GzDecoder::new(bytes.as_slice()).read_to_end(&mut unpacked).unwrap();
    unpacked
}

fn grid(name: &str, grid: &str) -> Grid {
    read(&file(name), grid, MOST).unwrap()
}

/// Compares every voxel of the leaves.
#[track_caller]
fn compare(grid: &Grid, count: usize, expected: impl Fn(IVec3) -> f32) {
    assert_eq!(grid.leaves.len(), count);
    for Leaf { lower, values } in &grid.leaves {
        for (index, value) in (0..512).zip(values.iter()) {
            let voxel = lower + ivec3(index >> 6, index >> 3 & 7, index & 7);
            assert_eq!(*value, expected(voxel), "at {voxel}");
        }
    }
}

/// The value of `ball` of make.py.
fn ball(radius: i32, background: f32) -> impl Fn(IVec3) -> f32 {
    move |voxel| {
        let at = voxel - ivec3(-12, 12, 12);
        match at.abs().element_sum() - radius {
            ..=0 => 0.125 * at.x as f32 + (at.y * at.y) as f32 - at.z as f32,
            1 => -3.0,
            2 => 7.0,
            _ => background,
        }
    }
}

/// The value of `leaf` of make.py.
fn leaf(kind: usize, background: f32, index: usize) -> f32 {
    let own = [background, -background, 7.0, -background, 7.0, 7.0, 7.0][kind];
    let other = [0.0, 0.0, 0.0, background, background, -3.0, -3.0][kind];
    match (index % 3, index % 5) {
        (0, _) => 0.125 * index as f32 + kind as f32,
        (_, 0) if kind >= 3 => other,
        _ => own,
    }
}

#[test]
fn blosc_and_grids_that_share_a_tree_are_read() {
    let density = grid("blosc.vdb", "density");
    compare(&density, 19, ball(9, 0.0));
    assert_eq!((density.background, density.tiles.len()), (0.0, 0));
    assert_eq!(density.active, Some((ivec3(-21, 3, 3), ivec3(-3, 21, 21))));
    assert_eq!(density.to_own, DAffine3::from_scale(DVec3::splat(0.5)));
    let shared = grid("blosc.vdb", "shared");
    compare(&shared, 19, ball(9, 0.0));
    assert_eq!(shared.to_own.transform_point3(DVec3::ONE), DVec3::new(3.0, 4.0, 5.0));
}

#[test]
fn tiles_of_all_sizes_are_read() {
    let levels = grid("levels.vdb", "levels");
    let tile = |x, size, value| Tile { lower: ivec3(x, 0, 0), size, value };
    let expected = [tile(4096, 4096, 5.0), tile(0, 128, 0.5), tile(128, 8, 0.25), tile(136, 8, 9.0)];
    assert_eq!((levels.background, levels.leaves.len()), (2.5, 0));
    assert_eq!(levels.tiles, expected);
    assert_eq!(levels.active, Some((IVec3::ZERO, ivec3(8191, 4095, 4095))));
    assert_eq!(levels.to_own, DAffine3::from_translation(DVec3::new(-1.0, 0.5, 0.0)));
}

#[test]
fn halves_are_read_and_a_map_that_shears() {
    let tilted = grid("half.vdb", "tilted");
    compare(&tilted, 7, ball(5, 0.5));
    assert_eq!(tilted.background, 0.5);
    assert_eq!(tilted.to_own.transform_point3(DVec3::X), DVec3::new(3.5, -3.875, 5.0));
    assert_eq!(tilted.to_own.transform_point3(DVec3::Z), DVec3::new(3.0, -3.875, 6.0));
}

#[test]
fn every_kind_of_inactive_values_is_read_with_zip_and_without_compression() {
    let inside = |lower: IVec3, voxel: IVec3| {
        let at = voxel - lower;
        ((at.z >> 3) as usize, (at.x * 64 + at.y * 8 + at.z % 8) as usize)
    };
    let zip = grid("zip.vdb", "density");
    compare(&zip, 7, |voxel| {
        let (kind, index) = inside(IVec3::ZERO, voxel);
        leaf(kind, 1.5, index)
    });
    assert_eq!(zip.active, Some((IVec3::ZERO, ivec3(7, 7, 55))));
    // Without any compression.
    let plain = grid("plain.vdb.gz", "density");
    compare(&plain, 1, |voxel| leaf(6, 1.5, inside(ivec3(-4096, 0, 4096), voxel).1));
    // The least and the greatest coordinates that there are.
    let mask = grid("mask.vdb", "density");
    let tile = |at, value| Tile { lower: IVec3::splat(at), size: 4096, value };
    assert_eq!(mask.tiles, [tile(i32::MAX - 4095, 0.75), tile(0, 0.5)]);
    assert_eq!(mask.active, Some((IVec3::MIN, IVec3::MAX)));
    compare(&mask, 3, |voxel| {
        let (number, index) = inside(IVec3::MIN, voxel);
        leaf([0, 2, 5][number], 0.0, index)
    });
}

#[test]
fn the_cloud_of_the_scenes_is_dense_within_and_thin_at_the_rim() {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/meshes/cloud.vdb"));
    let cloud = read(&std::fs::read(path).unwrap(), "density", 2 << 20).unwrap();
    let (first, last) = cloud.active.unwrap();
    let ends = [first, last].map(|voxel| cloud.to_own.transform_point3(voxel.as_dvec3()));
    assert_eq!(ends[0], -ends[1]);
    assert!(ends[1].x > 0.9 && ends[1].x < 1.0, "{ends:?}");
    let values = || cloud.leaves.iter().flat_map(|leaf| leaf.values.iter());
    assert!(values().all(|value| (0.0..=1.0).contains(value)));
    let count = |range: std::ops::Range<f32>| values().filter(|value| range.contains(value)).count();
    let (rim, inner) = (count(1e-6..0.5), count(0.5..2.0));
    assert!(rim > 40_000 && inner > 80_000, "{rim} {inner}");
}

#[test]
fn a_grid_is_found_by_its_name_and_its_number() {
    let value = |name| grid("several.vdb", name).leaves[0].values.iter().fold(0.0, |all: f32, value| all.max(*value));
    assert_eq!([value("density"), value("density[0]"), value("density[1]")], [4.0, 4.0, 5.0]);
    let missing = read(&file("several.vdb"), "densty", MOST).unwrap_err();
    assert_eq!(missing, "there is no grid \"densty\": expected one of \"density[0]\", \"density[1]\"");
    let missing = read(&file("zip.vdb"), "densty", MOST).unwrap_err();
    assert_eq!(missing, "there is no grid \"densty\": expected one of \"density\"; did you mean \"density\"?");
}

/// The map of the bytes that a file has for it.
fn map_of(name: &str, numbers: &[f64]) -> Result<DAffine3, String> {
    let mut bytes = (name.len() as u32).to_le_bytes().to_vec();
    bytes.extend(name.bytes());
    bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    let mut input = Input { bytes: &bytes, rest: &bytes };
    let map = map(&mut input)?;
    assert_eq!(input.rest.len(), 0, "{name}");
    Ok(map)
}

#[test]
fn linear_maps_are_read_and_others_are_refused() {
    let by = DVec3::new(2.0, 3.0, 4.0);
    let scale = |before: &[f64]| [before, &by.to_array(), &[9.0; 12]].concat();
    let moved = DAffine3::from_translation(DVec3::new(5.0, 6.0, 7.0));
    for name in ["UniformScaleMap", "ScaleMap"] {
        assert_eq!(map_of(name, &scale(&[])), Ok(DAffine3::from_scale(by)));
    }
    for name in ["UniformScaleTranslateMap", "ScaleTranslateMap"] {
        assert_eq!(map_of(name, &scale(&[5.0, 6.0, 7.0])), Ok(moved * DAffine3::from_scale(by)));
    }
    assert_eq!(map_of("TranslationMap", &[5.0, 6.0, 7.0]), Ok(moved));
    let turned = DAffine3::from_rotation_y(0.5);
    for name in ["AffineMap", "UnitaryMap"] {
        assert_eq!(map_of(name, &DMat4::from(turned).to_cols_array()), Ok(turned));
    }
    let frustum = map_of("NonlinearFrustumMap", &[1.0; 8]).unwrap_err();
    assert_eq!(frustum, "its map is \"NonlinearFrustumMap\", expected a linear one: resample it to a uniform grid");
    for flat in [0.0, f64::NAN, f64::INFINITY] {
        let message = map_of("ScaleMap", &[[flat; 15].as_slice()].concat()).unwrap_err();
        assert_eq!(message, "its ScaleMap has no inverse: give its voxels a size that is not 0");
    }
}

/// Replaces the first place where these bytes are.
fn replaced(bytes: &[u8], old: &[u8], new: &[u8]) -> Vec<u8> {
    let at = bytes.windows(old.len()).position(|window| window == old).expect("they are there");
    [&bytes[..at], new, &bytes[at + old.len()..]].concat()
}

#[track_caller]
fn refused(bytes: &[u8], expected: &str) {
    let message = read(bytes, "density", MOST).unwrap_err();
    assert_eq!(message, expected);
}

#[test]
fn what_is_not_read_is_refused_with_what_to_do() {
    let mask = file("mask.vdb");
    refused(b"", "expected an OpenVDB file (.vdb)");
    refused(&replaced(&mask, b"BDV", b"BDW"), "expected an OpenVDB file (.vdb)");
    for version in [221_u32, 226] {
        let message = format!("its version is {version}, expected 222 to 225: save it with another version of OpenVDB");
        refused(&[&mask[..8], &version.to_le_bytes(), &mask[12..]].concat(), &message);
    }
    let stream = "it was written as a stream, which does not say where its grids are: save it as a file";
    refused(&[&mask[..20], &[0], &mask[21..]].concat(), stream);
    for kind in ["Tree_double_5_4_3", "Tree_vec3s_5_4_3", "Tree_int32_5_4_3", "Tree_bool_5_4_3", "Tree_half_5_4_3"] {
        let message = format!("its type is {kind:?}, expected \"Tree_float_5_4_3\": save it as a FloatGrid");
        let new = [&[kind.len() as u8, 0, 0, 0], kind.as_bytes()].concat();
        // Only what comes before it stays where it was, which is enough.
        refused(&[replaced(&mask, b"\x10\0\0\0Tree_float_5_4_3", &new), vec![0; 8]].concat(), &message);
    }
    let start = mask.windows(12).position(|window| window == b"\x08\0\0\0ScaleMap").unwrap() - 8;
    let flags = [&mask[..start], &[8], &mask[start + 1..]].concat();
    refused(&flags, "its compression is 8, which is not known: save it with zip or with blosc");
}

#[test]
fn a_tree_that_is_shared_with_no_grid_is_refused() {
    // The parent is the last of the texts of the second descriptor.
    let blosc = replaced(&file("blosc.vdb"), b"\x07\0\0\0density", b"\x07\0\0\0densitx");
    let message = read(&blosc, "shared", MOST).unwrap_err();
    assert_eq!(message, "it has the values of \"density\", which is missing: save it anew");
}

#[test]
fn damage_is_named() {
    let mask = file("mask.vdb");
    let short = &mask[..mask.len() - 1];
    assert!(read(short, "density", MOST).unwrap_err().ends_with("it is not complete"));
    let end = mask.windows(8).position(|window| window == (mask.len() as u64).to_le_bytes()).unwrap();
    let circle = [&mask[..end], &[0; 8], &mask[end + 8..]].concat();
    refused(&circle, "its grids overlap: it is damaged");
    // The tiles of the root have values 0.75 and 0.5.
    let (old, least) = (0.75_f32.to_le_bytes(), i32::MAX - 4095);
    let message = format!("its value at voxel [{least}, {least}, {least}] is inf, expected a finite number");
    refused(&replaced(&mask, &old, &f32::INFINITY.to_le_bytes()), &message);
    let twice = replaced(&mask, &[0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x3f, 0], &{
        let mut tile = [least.to_le_bytes(); 3].concat();
        tile.extend([0, 0, 0, 0x3f, 0]);
        tile
    });
    refused(&twice, &format!("two nodes of its tree are at [{least}, {least}, {least}]: it is damaged"));
    let nan = replaced(&mask, &(0.125 * 9.0_f32).to_le_bytes(), &f32::NAN.to_le_bytes());
    refused(&nan, "its value at voxel [-2147483648, -2147483647, -2147483647] is NaN, expected a finite number");
    let background = replaced(&file("zip.vdb"), &1.5_f32.to_le_bytes(), &f32::NAN.to_le_bytes());
    refused(&background, "its background is NaN, expected a finite number");
}

#[test]
fn memory_is_limited() {
    let message = read(&file("zip.vdb"), "density", 1 << 13).unwrap_err();
    assert_eq!(message, "its values take more memory than grids may take: save it with larger voxels");
    let message = read(&file("levels.vdb"), "levels", 3 * size_of::<Tile>()).unwrap_err();
    assert!(message.starts_with("its values take more"), "{message}");
    assert!(read(&file("levels.vdb"), "levels", 4 * size_of::<Tile>()).is_ok());
}

/// The contents of a frame of blosc, as values of a leaf without any mask.
fn unpack(flags: u8, type_size: u8, block_size: u32, body: &[u8]) -> Result<Vec<f32>, String> {
    let header = [2, 1, flags, type_size];
    let size = 2048_u32;
    let frame = [&header, &size.to_le_bytes()[..], &block_size.to_le_bytes(), &[0; 4], body].concat();
    let bytes = [&[6], &(frame.len() as u64).to_le_bytes()[..], &frame].concat();
    let mut values = vec![0.0; 512];
    Coding::new(4, false)?.values(&mut Input { bytes: &bytes, rest: &bytes }, &[], &mut values)?;
    Ok(values)
}

/// A block of LZ4 without references.
fn literals(bytes: &[u8]) -> Vec<u8> {
    let rest = bytes.len() - 15;
    [&[0xf0], &vec![255; rest / 255][..], &[(rest % 255) as u8], bytes].concat()
}

fn zipped(bytes: &[u8]) -> Vec<u8> {
    let mut packed = Vec::new();
    flate2::read::ZlibEncoder::new(bytes, flate2::Compression::best()).read_to_end(&mut packed).unwrap();
    packed
}

/// A frame's blocks, each of which is parts.
fn body(blocks: &[Vec<Vec<u8>>]) -> Vec<u8> {
    let (mut starts, mut all) = (Vec::new(), Vec::new());
    for block in blocks {
        starts.extend(((16 + 4 * blocks.len() + all.len()) as u32).to_le_bytes());
        for part in block {
            all.extend((part.len() as u32).to_le_bytes());
            all.extend(part);
        }
    }
    [starts, all].concat()
}

#[test]
fn frames_of_blosc_are_read_however_they_are_packed() {
    let values: Vec<f32> = (0..512).map(|index| 0.125 * index as f32).collect();
    let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    let shuffled =
        |bytes: &[u8]| -> Vec<u8> { (0..4).flat_map(|byte| bytes.iter().copied().skip(byte).step_by(4)).collect() };
    let whole = Ok(values);
    assert_eq!(unpack(0x02, 4, 2048, &bytes), whole, "copied");
    assert_eq!(unpack(0x30, 4, 2048, &body(&[vec![literals(&bytes)]])), whole, "not split");
    assert_eq!(unpack(0x31, 4, 2048, &body(&[vec![literals(&shuffled(&bytes))]])), whole, "shuffled");
    let mut parts: Vec<Vec<u8>> = shuffled(&bytes).chunks(512).map(literals).collect();
    assert_eq!(unpack(0x21, 4, 2048, &body(&[parts.clone()])), whole, "split");
    parts[3] = shuffled(&bytes)[1536..].to_vec();
    assert_eq!(unpack(0x21, 4, 2048, &body(&[parts])), whole, "with a part that is as it was");
    // Blocks of 900 bytes, of which the last has 248.
    let blocks: Vec<_> = bytes.chunks(900).map(|block| vec![zipped(&shuffled(block))]).collect();
    assert_eq!(unpack(0x71, 4, 900, &body(&blocks)), whole, "zlib in several blocks");
}

#[test]
fn frames_of_blosc_that_are_not_read_say_what_to_do() {
    let block = body(&[vec![vec![0; 20]]]);
    let error = |flags| unpack(flags, 4, 2048, &block).unwrap_err();
    for (flags, name) in [(0x10, "BloscLZ"), (0x50, "Snappy"), (0x90, "Zstandard"), (0xb0, "a new codec")] {
        let expected = format!("blosc has packed its values with {name}, expected LZ4 or zlib: save it with zip");
        assert_eq!(error(flags), expected);
    }
    let bits = "blosc has shuffled the bits of its values: save it with zip";
    assert_eq!(error(0x34), bits);
    assert!(error(0x30).starts_with("expected 2048 bytes of values") || error(0x30).starts_with("cannot unpack"));
    assert!(error(0x70).starts_with("cannot unzip its values"), "{}", error(0x70));
    assert_eq!(unpack(0x02, 4, 2048, &[0; 9]).unwrap_err(), "expected 2048 more bytes, found 9: it is not complete");
}

/// The next of a row of numbers that look random (SplitMix64).
fn next(state: &mut u64) -> usize {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mixed = (*state ^ *state >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    ((mixed ^ mixed >> 27).wrapping_mul(0x94d0_49bb_1331_11eb) >> 33) as usize
}

/// Damages a file, three times in four in the part before the masks, which decides most.
fn damage(bytes: &mut Vec<u8>, state: &mut u64) {
    const NUMBERS: [u64; 8] = [0, 1, 0x7fff_ffff, 0x8000_0000, 0xffff_ffff, 1 << 62, 1 << 63, u64::MAX];
    for _ in 0..1 + next(state) % 3 {
        let reach = if next(state).is_multiple_of(4) { bytes.len() } else { bytes.len().min(1200) };
        let at = next(state) % reach.max(1);
        match next(state) % 8 {
            0..4 => bytes.iter_mut().skip(at).take(1).for_each(|byte| *byte ^= 1 << (next(state) % 8)),
            4 => bytes.iter_mut().skip(at).take(4).for_each(|byte| *byte = next(state) as u8),
            5 => bytes.truncate(next(state) % (bytes.len() + 1)),
            kind => {
                let number = NUMBERS[next(state) % NUMBERS.len()].to_le_bytes();
                let length = if kind == 6 { 4 } else { 8 };
                bytes.iter_mut().skip(at).zip(number).take(length).for_each(|(byte, new)| *byte = new);
            }
        }
    }
}

#[test]
fn damaged_files_neither_panic_nor_take_long_nor_much_memory() {
    let files = ["blosc.vdb", "levels.vdb", "half.vdb", "several.vdb", "zip.vdb", "mask.vdb", "plain.vdb.gz"];
    let names = ["density", "levels", "tilted", "density[1]", "density", "density", "density"];
    let mut outcomes: HashMap<bool, u32> = HashMap::new();
    for (name, grid) in files.into_iter().zip(names) {
        let whole = file(name);
        let mut state = name.len() as u64;
        for number in 0..2000 {
            let mut bytes = whole.clone();
            damage(&mut bytes, &mut state);
            let start = Instant::now();
            let result = read(&bytes, grid, MOST);
            assert!(start.elapsed() < Duration::from_secs(1), "{name} {number} took {:?}", start.elapsed());
            if let Ok(grid) = &result {
                let taken = grid.leaves.len() * 2048 + size_of_val(grid.tiles.as_slice());
                assert!(taken <= MOST, "{name} {number} took {taken} bytes");
            }
            *outcomes.entry(result.is_ok()).or_default() += 1;
        }
    }
    assert!(outcomes[&true] > 1000 && outcomes[&false] > 1000, "{outcomes:?}");
}

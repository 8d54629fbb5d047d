//! Reads grids of densities from OpenVDB files, in the format of OpenVDB 12 (io/Archive.cc and what it calls).
//!
//! A file is a header, and for each grid a descriptor, which says where the grid is and where the next descriptor is. `tree` reads the
//! values of a grid, and `packed` undoes their compression. No size that the file claims is trusted before as many bytes are there.

mod input;
mod packed;
#[cfg(test)]
mod tests;
mod tree;

use glam::{DAffine3, DMat4, DQuat, DVec3};

use super::nearest::{meant, one_of};
use crate::volume::grid::Grid;
use input::Input;
use packed::Coding;

type Result<T> = std::result::Result<T, String>;

const MAGIC: &[u8] = b" BDV\0\0\0\0";
/// The versions that are read. They differ only in what grids of floats do not have.
const VERSIONS: std::ops::RangeInclusive<u32> = 222..=225;
const FLOATS: &str = "Tree_float_5_4_3";
const HALVES: &str = "Tree_float_5_4_3_HalfFloat";
/// What separates the name of a grid from the number that tells it from others of this name.
const SEPARATOR: char = '\x1e';
const UUID: usize = 36;

/// The grid of this name, or the first of several; "name[1]" names the second. Its leaves and tiles may take `most_bytes`.
pub fn read(bytes: &[u8], name: &str, most_bytes: usize) -> Result<Grid> {
    let entries = entries(bytes)?;
    let names = || entries.iter().map(|entry| entry.name.as_str());
    let (expected, meant) = (one_of(names(), "the file has no grids"), meant(name, names()));
    let found = entries.iter().find(|entry| entry.name == name);
    let found = found.or_else(|| entries.iter().find(|entry| entry.base == name));
    let entry = found.ok_or_else(|| format!("there is no grid {name:?}: {expected}{meant}"))?;
    let (mut tree, mut coding) = entry.open(bytes)?;
    let to_own = map(&mut tree)?;
    if !entry.parent.is_empty() {
        // The grid has the tree of another.
        let parent = entries.iter().find(|other| other.name == entry.parent && other.parent.is_empty());
        let missing = || format!("its values are those of a grid {:?}, which is missing: save it anew", entry.parent);
        (tree, coding) = parent.ok_or_else(missing)?.open(bytes)?;
        map(&mut tree)?;
    }
    tree::read(tree, coding, to_own, most_bytes)
}

/// A descriptor of a grid.
struct Entry {
    /// The name, with "[1]" behind it if it is the second of this name, and the name alone.
    name: String,
    base: String,
    kind: String,
    /// The name of the grid whose tree this one shares, or nothing.
    parent: String,
    /// Where the grid begins in the file.
    start: u64,
}

impl Entry {
    /// What begins with the grid's map, and how its values are stored.
    fn open<'a>(&self, bytes: &'a [u8]) -> Result<(Input<'a>, Coding)> {
        if ![FLOATS, HALVES].contains(&self.kind.as_str()) {
            return Err(format!("its type is {:?}, expected {FLOATS:?}: save it as a FloatGrid", self.kind));
        }
        let mut input = Input { bytes, rest: bytes };
        input.seek(self.start)?;
        let [flags] = input.words()?;
        let coding = Coding::new(flags, self.kind == HALVES)?;
        skip_metadata(&mut input)?;
        Ok((input, coding))
    }
}

/// The descriptors of all grids.
fn entries(bytes: &[u8]) -> Result<Vec<Entry>> {
    let mut input = Input { bytes, rest: bytes.strip_prefix(MAGIC).ok_or("expected an OpenVDB file (.vdb)")? };
    let [version, ..] = input.words::<3>()?;
    if !VERSIONS.contains(&version) {
        let (first, last) = VERSIONS.into_inner();
        return Err(format!(
            "its version is {version}, expected {first} to {last}: save it with another version of OpenVDB"
        ));
    }
    if input.array()? == [0] {
        return Err("it was written as a stream, which does not say where its grids are: save it as a file".to_owned());
    }
    input.take(UUID)?;
    skip_metadata(&mut input)?;
    let [count] = input.words()?;
    let mut entries = Vec::new();
    for _ in 0..count {
        let [unique, kind, parent] = [input.text()?, input.text()?, input.text()?];
        let [start, _, end] = [input.array()?, input.array()?, input.array()?].map(u64::from_le_bytes);
        // The number of a grid among those of its name.
        let shown =
            |name: String| name.split_once(SEPARATOR).map(|(base, number)| format!("{base}[{number}]")).unwrap_or(name);
        let base = unique.split(SEPARATOR).next().unwrap_or_default().to_owned();
        entries.push(Entry { name: shown(unique), base, kind, parent: shown(parent), start });
        // A descriptor before this one would be read for ever.
        if end < input.position() {
            return Err("its grids overlap: it is damaged".to_owned());
        }
        input.seek(end)?;
    }
    Ok(entries)
}

/// Skips a list of facts: a name, a type and a value of each.
fn skip_metadata(input: &mut Input) -> Result<()> {
    let [count] = input.words()?;
    (0..count).try_for_each(|_| (0..3).try_for_each(|_| input.counted().map(drop)))
}

/// The map from index space to the grid's own space.
fn map(input: &mut Input) -> Result<DAffine3> {
    let name = input.text()?;
    // The numbers that the patterns leave out follow from the scale.
    let map = match name.as_str() {
        "UniformScaleMap" | "ScaleMap" => {
            let [x, y, z, ..] = input.doubles::<15>()?;
            DAffine3::from_scale(DVec3::new(x, y, z))
        }
        "UniformScaleTranslateMap" | "ScaleTranslateMap" => {
            let [x, y, z, by @ ..] = input.doubles::<6>()?;
            input.doubles::<12>()?;
            DAffine3::from_scale_rotation_translation(by.into(), DQuat::IDENTITY, DVec3::new(x, y, z))
        }
        "TranslationMap" => DAffine3::from_translation(input.doubles()?.into()),
        // OpenVDB multiplies rows: what are rows to it are columns here.
        "AffineMap" | "UnitaryMap" => DAffine3::from_mat4(DMat4::from_cols_array(&input.doubles()?)),
        _ => {
            return Err(format!("its map is {name:?}, expected a linear one: resample it to a grid with a linear map"));
        }
    };
    match map.is_finite() && map.matrix3.determinant() != 0.0 && map.inverse().is_finite() {
        true => Ok(map),
        false => Err(format!("its {name} has no inverse: give its voxels a size that is not 0")),
    }
}

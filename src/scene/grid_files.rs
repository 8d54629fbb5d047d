//! Reads grids of densities from OpenVDB files, in the format of OpenVDB 12 (io/Archive.cc and what it calls).
//!
//! A file is a header, and for each grid a descriptor, which says where the grid is and where the next descriptor is. `tree` reads the
//! values of a grid, and `packed` undoes their compression. No size that the file claims is trusted before as many bytes are there.

mod input;
mod packed;
#[cfg(test)]
mod tests;
mod tree;

use glam::{DAffine3, DMat4, DQuat};

use super::nearest::{meant, one_of};
use crate::printable::quote;
use crate::volume::grid::Grid;
use input::Input;
use packed::Coding;

type Result<T> = std::result::Result<T, String>;

const MAGIC: &[u8] = b" BDV\0\0\0\0";
const FLOATS: &str = "Tree_float_5_4_3";
const HALVES: &str = "Tree_float_5_4_3_HalfFloat";
/// The character that separates the name of a grid from the number that tells it from others of this name.
const SEPARATOR: char = '\x1e';
const UUID: usize = 36;

/// The grid of this name, or the first of several; "name[1]" names the second. Its leaves and tiles may take `most_bytes`.
pub fn read(bytes: &[u8], name: &str, most_bytes: usize) -> Result<Grid> {
    let entries = entries(bytes)?;
    let shown = |entry: &Entry| entry.name.split_once(SEPARATOR).map(|(base, number)| format!("{base}[{number}]"));
    let names: Vec<String> = entries.iter().map(|entry| shown(entry).unwrap_or(entry.name.clone())).collect();
    let index = names.iter().position(|shown| shown == name);
    let index = index.or_else(|| entries.iter().position(|entry| entry.name.split(SEPARATOR).next() == Some(name)));
    let entry = index.and_then(|index| entries.get(index)).ok_or_else(|| {
        // Names of a damaged file may be very long.
        let names = || names.iter().map(|name| name.get(..100).unwrap_or(name));
        let (expected, meant) = (one_of(names(), "the file has no grids"), meant(name, names()));
        format!("there is no grid {name:?}: {expected}{meant}")
    })?;
    let (mut tree, mut coding) = entry.open(bytes)?;
    let to_own = map(&mut tree)?;
    if !entry.parent.is_empty() {
        let parent = entries.iter().find(|other| other.name == entry.parent && other.parent.is_empty());
        let missing = || format!("it has the values of {}, which is missing: save it anew", quote(&entry.parent));
        (tree, coding) = parent.ok_or_else(missing)?.open(bytes)?;
        map(&mut tree)?;
    }
    tree::read(tree, coding, to_own, most_bytes)
}

/// A descriptor of a grid.
struct Entry {
    /// The name, which no other grid of the file has.
    name: String,
    kind: String,
    /// The name of the grid whose tree this one shares, or nothing.
    parent: String,
    /// Where the grid begins in the file.
    start: u64,
}

impl Entry {
    /// The bytes that begin with the grid's map, and how its values are stored.
    fn open<'a>(&self, bytes: &'a [u8]) -> Result<(Input<'a>, Coding)> {
        if ![FLOATS, HALVES].contains(&self.kind.as_str()) {
            return Err(format!("its type is {}, expected {FLOATS:?}: save it as a FloatGrid", quote(&self.kind)));
        }
        let mut input = Input { bytes, rest: bytes };
        input.seek(self.start)?;
        let coding = Coding::new(input.read()?, self.kind == HALVES)?;
        skip_metadata(&mut input)?;
        Ok((input, coding))
    }
}

/// The descriptors of all grids.
fn entries(bytes: &[u8]) -> Result<Vec<Entry>> {
    let mut input = Input { bytes, rest: bytes.strip_prefix(MAGIC).ok_or("expected an OpenVDB file (.vdb)")? };
    let [version, ..]: [u32; 3] = input.read()?;
    // The versions differ only in what grids of floats do not have.
    if !(222..=225).contains(&version) {
        return Err(format!("its version is {version}, expected 222 to 225: save it with another version of OpenVDB"));
    }
    if input.read::<u8>()? == 0 {
        return Err("it was written as a stream, which does not say where its grids are: save it as a file".to_owned());
    }
    input.take(UUID)?;
    skip_metadata(&mut input)?;
    let mut entries = Vec::new();
    for _ in 0..input.read::<u32>()? {
        let [name, kind, parent] = [input.text()?, input.text()?, input.text()?];
        let [start, _, end]: [u64; 3] = input.read()?;
        entries.push(Entry { name, kind, parent, start });
        let left = input.rest.len();
        input.seek(end)?;
        // A descriptor before this one would be read for ever.
        if input.rest.len() > left {
            return Err("its grids overlap: it is damaged".to_owned());
        }
    }
    Ok(entries)
}

/// Skips a list of facts: a name, a type and a value of each.
fn skip_metadata(input: &mut Input) -> Result<()> {
    (0..input.read::<u32>()?).try_for_each(|_| (0..3).try_for_each(|_| input.counted().map(drop)))
}

/// The map from index space to the grid's own space.
fn map(input: &mut Input) -> Result<DAffine3> {
    let name = input.text()?;
    // Four vectors behind a scale follow from it.
    let map = match name.as_str() {
        "UniformScaleMap" | "ScaleMap" => DAffine3::from_scale(input.read::<[[f64; 3]; 5]>()?[0].into()),
        "UniformScaleTranslateMap" | "ScaleTranslateMap" => {
            let [translation, scale, ..]: [[f64; 3]; 6] = input.read()?;
            DAffine3::from_scale_rotation_translation(scale.into(), DQuat::IDENTITY, translation.into())
        }
        "TranslationMap" => DAffine3::from_translation(input.read::<[f64; 3]>()?.into()),
        // OpenVDB multiplies rows: what are rows to it are columns here.
        "AffineMap" | "UnitaryMap" => DAffine3::from_mat4(DMat4::from_cols_array(&input.read()?)),
        _ => return Err(format!("its map is {}, expected a linear one: resample it to a uniform grid", quote(&name))),
    };
    match map.is_finite() && map.matrix3.determinant() != 0.0 && map.inverse().is_finite() {
        true => Ok(map),
        false => Err(format!("its {name} has no inverse: give its voxels a size that is not 0")),
    }
}

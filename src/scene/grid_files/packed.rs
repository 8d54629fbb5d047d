//! The values of a node: which of them are stored, as floats or halves, and their compression.

use std::io::Read;

use ::exr::prelude::f16;
use flate2::read::ZlibDecoder;

use super::{Input, Result};

/// The flags of a grid's compression.
const ZIP: u32 = 1;
const ACTIVE_MASK: u32 = 2;
const BLOSC: u32 = 4;
/// The flags of a frame of blosc.
const SHUFFLED: u8 = 1;
const COPIED: u8 = 2;
const BITS_SHUFFLED: u8 = 4;
const NOT_SPLIT: u8 = 16;

/// How a grid's values are stored.
pub struct Coding {
    flags: u32,
    is_half: bool,
    /// The value that nodes do not store.
    pub background: f32,
}

impl Coding {
    pub fn new(flags: u32, is_half: bool) -> Result<Coding> {
        match flags & !(ZIP | ACTIVE_MASK | BLOSC) {
            0 => Ok(Coding { flags, is_half, background: 0.0 }),
            _ => Err(format!("its compression is {flags}, which is not known: save it with zip or with blosc")),
        }
    }

    /// Fills `values` with those of a node. `active` has a bit for each.
    pub fn values(&self, input: &mut Input, active: &[u8], values: &mut [f32]) -> Result<()> {
        // The inactive values are one number, or a mask says which of two each is. The kind says which numbers follow and whether the
        // mask does; of kind 6 all values are stored.
        let kind: u8 = input.read()?;
        let mut inactive = [if kind == 0 { self.background } else { -self.background }, self.background];
        let Some(&follow) = [0, 0, 1, 0, 1, 2, 0].get(usize::from(kind)) else {
            return Err(format!("expected 0 to 6 before the values of a node, found {kind}: it is damaged"));
        };
        for value in inactive.iter_mut().take(follow) {
            *value = input.read()?;
        }
        let selected = if (3..=5).contains(&kind) { input.take(active.len())? } else { &[] };
        let are_all = self.flags & ACTIVE_MASK == 0 || kind == 6;
        let count = if are_all { values.len() } else { active.iter().map(|bits| bits.count_ones() as usize).sum() };
        let mut stored = self.stored(input, count)?.into_iter();
        for (index, value) in values.iter_mut().enumerate() {
            let is_stored = are_all || bit(active, index);
            let next = if is_stored { stored.next() } else { None };
            *value = next.unwrap_or(inactive[usize::from(bit(selected, index))]);
        }
        Ok(())
    }

    fn stored(&self, input: &mut Input, count: usize) -> Result<Vec<f32>> {
        if !self.is_half {
            let bytes = self.unpack(input, 4 * count)?;
            return Ok(bytes.as_chunks().0.iter().map(|float| f32::from_le_bytes(*float)).collect());
        }
        // If there are no halves, not even the size is stored.
        let bytes = if count > 0 { self.unpack(input, 2 * count)? } else { Vec::new() };
        Ok(bytes.as_chunks().0.iter().map(|half| f16::from_le_bytes(*half).to_f32()).collect())
    }

    /// The next `size` bytes of values.
    fn unpack(&self, input: &mut Input, size: usize) -> Result<Vec<u8>> {
        // A block that compression does not make smaller is stored as it is, with its size below 0.
        let packed = if self.flags & (ZIP | BLOSC) != 0 { input.read()? } else { -(size as i64) };
        if packed <= 0 {
            same(size, packed.unsigned_abs())?;
            return input.take(size).map(<[u8]>::to_vec);
        }
        let packed = input.take(usize::try_from(packed).unwrap_or(usize::MAX))?;
        let mut values = vec![0; size];
        let unpack = if self.flags & BLOSC != 0 { unpack_blosc } else { unzip };
        unpack(packed, &mut values).map(|()| values)
    }
}

/// Whether the bit of this number is set. Bits that are missing are not.
pub fn bit(mask: &[u8], index: usize) -> bool {
    mask.get(index / 8).is_some_and(|bits| bits >> (index % 8) & 1 != 0)
}

fn same(expected: usize, found: u64) -> Result<()> {
    match expected as u64 == found {
        true => Ok(()),
        false => Err(format!("expected {expected} bytes of values, found {found}: it is damaged")),
    }
}

fn unzip(packed: &[u8], values: &mut [u8]) -> Result<()> {
    ZlibDecoder::new(packed).read_exact(values).map_err(|error| format!("cannot unzip its values: {error}"))
}

/// Unpacks a frame of blosc 1: blocks, each of which may be split into parts (c-blosc's blosc/blosc.c, blosc_d).
fn unpack_blosc(frame: &[u8], values: &mut [u8]) -> Result<()> {
    let mut input = Input { bytes: frame, rest: frame };
    let [_, _, flags, type_size]: [u8; 4] = input.read()?;
    let [size, block_size, _]: [u32; 3] = input.read()?;
    same(values.len(), size.into())?;
    if flags & COPIED != 0 {
        values.copy_from_slice(input.take(values.len())?);
        return Ok(());
    }
    if flags & BITS_SHUFFLED != 0 {
        return Err("blosc has shuffled the bits of its values: save it with zip".to_owned());
    }
    let unpack = match flags >> 5 {
        1 => unpack_lz4,
        3 => unzip,
        codec => {
            let name = ["BloscLZ", "", "Snappy", "", "Zstandard"].get(usize::from(codec)).unwrap_or(&"a new codec");
            return Err(format!("blosc has packed its values with {name}, expected LZ4 or zlib: save it with zip"));
        }
    };
    let (type_size, block_size) = (usize::from(type_size).max(1), (block_size as usize).max(1));
    for block in values.chunks_mut(block_size) {
        let mut parts = Input { bytes: frame, rest: frame };
        parts.seek(input.read::<u32>()?.into())?;
        let can_split = flags & NOT_SPLIT == 0 && type_size <= 16 && block_size / type_size >= 128;
        let count = if can_split && block.len() == block_size { type_size } else { 1 };
        for part in block.chunks_mut(block.len() / count) {
            match parts.counted()? {
                stored if stored.len() == part.len() => part.copy_from_slice(stored),
                packed => unpack(packed, part)?,
            }
        }
        if flags & SHUFFLED != 0 {
            unshuffle(block, type_size);
        }
    }
    Ok(())
}

fn unpack_lz4(packed: &[u8], values: &mut [u8]) -> Result<()> {
    let size = lz4_flex::block::decompress_into(packed, values);
    same(values.len(), size.map_err(|error| format!("cannot unpack its values: {error}"))? as u64)
}

/// Undoes that the first bytes of all values come first, then their second bytes, and so on.
fn unshuffle(block: &mut [u8], type_size: usize) {
    let (shuffled, count) = (block.to_vec(), block.len() / type_size);
    for (index, &byte) in shuffled.iter().enumerate().take(count * type_size) {
        block[index % count * type_size + index / count] = byte;
    }
}

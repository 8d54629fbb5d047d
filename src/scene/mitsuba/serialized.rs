//! Mitsuba's own meshes: several in a file, each compressed.

use std::io::Read;

use flate2::read::ZlibDecoder;
use glam::{DVec3, Vec2};

use crate::error::require;
use crate::scene::draft::{Draft, MOST_BYTES};
use crate::shape::mesh::Mesh;

const MAGIC: u64 = 0x041c;
const HAS_NORMALS: u32 = 1;
const HAS_UVS: u32 = 2;
const HAS_COLOURS: u32 = 8;
const FACE_NORMALS: u32 = 16;
const DOUBLE: u32 = 0x2000;

/// The mesh of this number, counted from 0.
pub fn read(bytes: &[u8], number: usize) -> Result<Mesh, String> {
    let broken = || "expected a serialized mesh of Mitsuba, of version 3 or 4".to_owned();
    let integer = |at: usize, length: usize| {
        let all = bytes.get(at..at.checked_add(length)?)?;
        Some(all.iter().rev().fold(0u64, |all, byte| all << 8 | u64::from(*byte)))
    };
    let version = integer(2, 2).filter(|version| integer(0, 2) == Some(MAGIC) && (3..=4).contains(version));
    let version = version.ok_or_else(broken)?;
    let size = if version == 4 { 8 } else { 4 };
    let end = bytes.len().checked_sub(4).ok_or_else(broken)?;
    let count = integer(end, 4).ok_or_else(broken)? as usize;
    require(number < count, || format!("there is no mesh {number}: the file has {count}"))?;
    let table = count.checked_mul(size).and_then(|length| end.checked_sub(length)).ok_or_else(broken)?;
    let offset = integer(table + number * size, size).ok_or_else(broken)?;
    let start = usize::try_from(offset).ok().and_then(|offset| offset.checked_add(4)).ok_or_else(broken)?;
    let mut input = ZlibDecoder::new(bytes.get(start..).ok_or_else(broken)?);
    mesh(&mut input, version)
}

fn mesh(input: &mut impl Read, version: u64) -> Result<Mesh, String> {
    let flags = u32::from_le_bytes(bytes(input)?);
    if version == 4 {
        while bytes::<1>(input)? != [0] {}
    }
    let (vertices, triangles) = (u64::from_le_bytes(bytes(input)?), u64::from_le_bytes(bytes(input)?));
    let is_double = flags & DOUBLE != 0;
    let next = |input: &mut _| match is_double {
        true => bytes(input).map(f64::from_le_bytes),
        false => bytes(input).map(|four| f64::from(f32::from_le_bytes(four))),
    };
    let mut draft = Draft::new(MOST_BYTES);
    for _ in 0..vertices {
        draft.vertex(DVec3::new(next(input)?, next(input)?, next(input)?))?;
    }
    if flags & HAS_NORMALS != 0 {
        for _ in 0..vertices {
            let normal = DVec3::new(next(input)?, next(input)?, next(input)?).as_vec3();
            if flags & FACE_NORMALS == 0 {
                draft.normals.push(normal);
            }
        }
    }
    if flags & HAS_UVS != 0 {
        for _ in 0..vertices {
            draft.uvs.push(Vec2::new(next(input)? as f32, next(input)? as f32));
        }
    }
    if flags & HAS_COLOURS != 0 {
        for _ in 0..3 * vertices {
            next(input)?;
        }
    }
    for _ in 0..triangles {
        let mut corner = || bytes(input).map(u32::from_le_bytes);
        draft.face(&[corner()?, corner()?, corner()?])?;
    }
    draft.finish()
}

fn bytes<const N: usize>(input: &mut impl Read) -> Result<[u8; N], String> {
    let mut all = [0; N];
    input.read_exact(&mut all).map_err(|error| format!("the mesh is not complete: {error}"))?;
    Ok(all)
}

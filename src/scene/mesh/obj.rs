//! Wavefront OBJ: positions, texture coordinates, normals and faces; all else (materials, groups, lines) is passed over.

use std::collections::HashMap;
use std::path::Path;

use glam::{DVec3, Vec2, Vec3};

use super::draft::Draft;
use super::input::{Input, number, quote, words};

/// Stands for a reference that a corner does not have.
const NONE: u32 = u32::MAX;

/// What the file lists, before faces pick from it.
#[derive(Default)]
struct Lists {
    positions: Vec<DVec3>,
    uvs: Vec<Vec2>,
    normals: Vec<Vec3>,
    /// The vertices: which position, texture coordinates and normal a corner refers to, counted from 0.
    corners: Vec<[u32; 3]>,
    /// The vertices' numbers.
    numbers: HashMap<[u32; 3], u32>,
}

pub fn parse(_: &Path, input: &mut Input) -> Result<Draft, String> {
    let mut draft = Draft::default();
    let mut lists = Lists::default();
    let mut face = Vec::new();
    let mut joined = Vec::new();
    let mut line_number = 0_u64;
    while let Some(mut line) = input.line() {
        line_number += 1;
        let first = line_number;
        if line.ends_with(b"\\") {
            joined.clear();
            while let Some(begun) = line.strip_suffix(b"\\") {
                joined.extend_from_slice(begun);
                joined.push(b' ');
                line = input.line().unwrap_or_default();
                line_number += 1;
            }
            joined.extend_from_slice(line);
            line = &joined;
        }
        lists.line(line, &mut draft, &mut face).map_err(|reason| format!("line {first}: {reason}"))?;
    }
    lists.fill(draft)
}

impl Lists {
    fn line(&mut self, line: &[u8], draft: &mut Draft, face: &mut Vec<u32>) -> Result<(), String> {
        let mut words = words(line);
        match words.next() {
            // More numbers may follow: a weight, which polygons have no use for, or a colour.
            Some(b"v") => self.positions.push(DVec3::from_array(numbers(words, 3)?)),
            Some(b"vt") => {
                let [u, v] = numbers(words, 1)?;
                self.uvs.push(Vec2::new(u as f32, v as f32));
            }
            Some(b"vn") => self.normals.push(DVec3::from_array(numbers(words, 3)?).as_vec3()),
            Some(b"f") => {
                face.clear();
                for word in words.take_while(|word| !word.starts_with(b"#")) {
                    let corner = self.corner(word).ok_or_else(|| {
                        format!(
                            "face {} (counted from 0): expected a corner such as 5, 5/2, 5//3 or 5/2/3 that refers to \
                             what the file has, counted from 1, found {}",
                            draft.next_face(),
                            quote(word)
                        )
                    })?;
                    face.push(self.number(corner)?);
                }
                draft.face(face)?;
            }
            _ => {}
        }
        Ok(())
    }

    /// What a corner refers to. Numbers below 0 count backwards from the last entry so far.
    fn corner(&self, word: &[u8]) -> Option<[u32; 3]> {
        let mut parts = word.split(|&byte| byte == b'/');
        let position = reference(parts.next()?, self.positions.len())?;
        let mut optional = |count| match parts.next() {
            None | Some(b"") => Some(NONE),
            Some(part) => reference(part, count),
        };
        let (uv, normal) = (optional(self.uvs.len())?, optional(self.normals.len())?);
        parts.next().is_none().then_some([position, uv, normal])
    }

    /// The vertex of a corner.
    fn number(&mut self, corner: [u32; 3]) -> Result<u32, String> {
        let next = u32::try_from(self.corners.len()).map_err(|_| "it has more than 2^32 - 1 vertices")?;
        let number = *self.numbers.entry(corner).or_insert(next);
        if number == next {
            self.corners.push(corner);
        }
        Ok(number)
    }

    /// Gives the vertices what their corners refer to, which may stand in the file after the faces.
    fn fill(self, mut draft: Draft) -> Result<Draft, String> {
        drop(self.numbers);
        let nowhere = |[position, uv, normal]: [u32; 3]| {
            let references = [
                (position, "position", self.positions.len()),
                (uv, "pair of texture coordinates", self.uvs.len()),
                (normal, "normal", self.normals.len()),
            ];
            references.into_iter().find(|&(index, _, count)| index != NONE && index as usize >= count)
        };
        if let Some(vertex) = self.corners.iter().position(|&corner| nowhere(corner).is_some()) {
            let (index, what, count) = self.corners.get(vertex).copied().and_then(nowhere).unwrap_or_default();
            let face = draft.face_of_vertex(vertex as u32).map_or(String::new(), |face| face.to_string());
            return Err(format!(
                "face {face} (counted from 0): there is no {what} {}, for the file has {count}, counted from 1",
                u64::from(index) + 1
            ));
        }
        let has = |at: usize| self.corners.iter().any(|corner| corner.get(at).is_some_and(|&index| index != NONE));
        let positions = self.corners.iter().map(|[p, _, _]| self.positions.get(*p as usize).copied());
        draft.positions = positions.map(|position| position.unwrap_or(DVec3::NAN)).collect();
        if has(1) {
            let uvs = self.corners.iter().map(|[_, uv, _]| self.uvs.get(*uv as usize).copied());
            draft.uvs = uvs.map(|uv| uv.unwrap_or(Vec2::NAN)).collect();
        }
        if has(2) {
            let normals = self.corners.iter().map(|[_, _, normal]| self.normals.get(*normal as usize).copied());
            draft.normals = normals.map(|normal| normal.unwrap_or(Vec3::NAN)).collect();
        }
        Ok(draft)
    }
}

/// A reference counted from 0. What is above the count may still come.
fn reference(word: &[u8], count: usize) -> Option<u32> {
    let index = match number::<i64>(word)? {
        back if back < 0 => i64::try_from(count).ok()?.checked_add(back)?,
        index => index.checked_sub(1)?,
    };
    u32::try_from(index).ok().filter(|&index| index != NONE)
}

/// The first N numbers of a line, of which some must be there; those that are not are 0.
fn numbers<'a, const N: usize>(mut words: impl Iterator<Item = &'a [u8]>, least: usize) -> Result<[f64; N], String> {
    let mut numbers = [0.0; N];
    for (index, to) in numbers.iter_mut().enumerate() {
        *to = match words.next() {
            Some(word) => number(word).ok_or_else(|| format!("expected a number, found {}", quote(word)))?,
            None if index >= least => break,
            None => return Err(format!("expected {least} numbers, found {index}")),
        };
    }
    Ok(numbers)
}

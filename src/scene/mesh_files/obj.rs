//! Wavefront OBJ: positions, texture coordinates, normals and faces, as the crate `tobj` reads them.
//!
//! The crate gets only the lines of these kinds, with continued lines joined, and without comments, weights and
//! colours. With all lines it would split faces at groups and materials before all vertices are known, and count lines
//! as faces. It would also refuse colours of only some vertices, texture coordinates of one number, continued lines,
//! comments behind a face, and text that is not UTF-8. Its errors name no position, so `fault` searches a refused file
//! for it.

use std::io::{self, BufRead, Read};
use std::path::Path;

use glam::{DVec3, Vec2, Vec3};
use tobj::LoadOptions;

use super::draft::{Draft, LARGEST};
use super::input::{Input, number, quote, words};
use crate::guard::guarded;

/// The crate makes one vertex for each combination of position, texture coordinates and normal, and keeps all faces as they are.
const OPTIONS: LoadOptions =
    LoadOptions { single_index: true, triangulate: false, ignore_points: false, ignore_lines: false };

/// The memory that the crate may take for a file, and what it takes for an entry of a list, for a face and for a corner of it. A
/// corner may become a vertex, which is in its table of vertices too.
const MOST_BYTES: usize = 5 << 29;
const ENTRY: usize = 24;
const FACE: usize = 104;
const CORNER: usize = 96;

pub fn parse(_: &Path, input: &mut Input, draft: &mut Draft) -> Result<(), String> {
    let bytes = input.rest();
    let mut lines = Lines::new(input);
    let loaded = guarded(|| tobj::load_obj_buf(&mut lines, &OPTIONS, |_| Ok(Default::default())));
    if lines.room.is_none() {
        return Err(format!(
            "it takes more than {} MiB of memory to read: split it into several files, or save it as .ply or .glb",
            MOST_BYTES >> 20
        ));
    }
    let has = lines.counts.map(|count| count > 0);
    if let Some(library) = lines.library {
        draft.warnings.push(format!(
            "its materials, in {library} (mtllib), are not read: the mesh has the one that the scene gives it"
        ));
    }
    let models = loaded.and_then(|loaded| loaded.map_err(|error| error.to_string()));
    let (models, _) = models.map_err(|words| fault(bytes).unwrap_or(words))?;
    for model in models {
        let mesh = model.mesh;
        if (!has[1] && !mesh.texcoords.is_empty()) || (!has[2] && !mesh.normals.is_empty()) {
            return Err(
                fault(bytes).unwrap_or_else(|| "a face refers to an entry that the file does not have".to_owned())
            );
        }
        for position in triples(&mesh.positions) {
            if !position.abs().cmple(DVec3::splat(LARGEST)).all() {
                return Err(not_finite(bytes, 0));
            }
            draft.vertex(position)?;
        }
        let count = draft.positions.len();
        let normals: Vec<Vec3> = triples(&mesh.normals).map(|normal| normal.as_vec3()).collect();
        let uvs = mesh.texcoords.as_chunks().0.iter().map(|&[u, v]| Vec2::new(u as f32, v as f32));
        let uvs: Vec<Vec2> = uvs.collect();
        draft.bad_normal = normals.iter().any(|normal| !normal.is_finite()).then(|| not_finite(bytes, 2));
        draft.bad_uv = uvs.iter().any(|uv| !uv.is_finite()).then(|| not_finite(bytes, 1));
        draft.normals = complete(normals, count, Vec3::NAN);
        draft.uvs = complete(uvs, count, Vec2::NAN);
        if mesh.face_arities.is_empty() {
            draft.reserve(mesh.indices.len() / 3);
            for corners in mesh.indices.chunks_exact(3) {
                draft.face(corners)?;
            }
        }
        let mut corners = mesh.indices.as_slice();
        for &count in &mesh.face_arities {
            let (face, rest) = corners.split_at_checked(count as usize).unwrap_or((corners, &[]));
            draft.face(face)?;
            corners = rest;
        }
    }
    Ok(())
}

/// The first entry of a list that is no finite numbers, with its line. Texture coordinates and normals are read as f32.
fn not_finite(bytes: &[u8], list: usize) -> String {
    let (largest, limit) = if list == 0 { (LARGEST, "1e100") } else { (f64::from(f32::MAX), "3.4e38") };
    let expected = format!("expected finite numbers of at most {limit} in magnitude");
    let mut tell = |_| {};
    let mut input = Input::new(bytes, &mut tell);
    let mut lines = Lines::new(&mut input);
    while lines.advance() {
        let mut words = words(&lines.line);
        if words.next() != LISTS.get(list).map(|(name, _)| *name) {
            continue;
        }
        let fits = |word: &&[u8]| number::<f64>(word).is_some_and(|number| number.abs() <= largest);
        if let Some(word) = words.find(|word| !fits(word)) {
            return format!("line {}: {expected}, found {}", lines.number, quote(word));
        }
    }
    expected
}

fn triples(numbers: &[f64]) -> impl Iterator<Item = DVec3> {
    numbers.as_chunks().0.iter().map(|&triple| DVec3::from_array(triple))
}

/// Replaces all values by `missing` if only some vertices have one, because the crate does not say which vertices they are.
fn complete<T: Clone>(values: Vec<T>, count: usize, missing: T) -> Vec<T> {
    if values.is_empty() || values.len() == count { values } else { vec![missing; count] }
}

/// The lists of an OBJ file, in the order of a corner's references.
const LISTS: [(&[u8], &str); 3] = [(b"v", "position"), (b"vt", "pair of texture coordinates"), (b"vn", "normal")];

/// An iterator over the lines that the crate gets.
struct Lines<'a, 'b> {
    input: &'a mut Input<'b>,
    /// The current line, which may be read in part.
    line: Vec<u8>,
    read: usize,
    /// The line number in the file at which the current line begins, and that of the next line.
    number: u64,
    next: u64,
    /// The number of entries so far in each list.
    counts: [u64; 3],
    /// The bytes that are left for the crate; none if it needs more.
    room: Option<usize>,
    /// The file of materials that is named first.
    library: Option<String>,
    /// The number of lists that `fill_lists` has handled after the end of the file.
    ended: usize,
}

impl<'a, 'b> Lines<'a, 'b> {
    fn new(input: &'a mut Input<'b>) -> Lines<'a, 'b> {
        let (counts, room) = ([0; 3], Some(MOST_BYTES));
        Lines { input, line: Vec::new(), read: 0, number: 0, next: 1, counts, room, library: None, ended: 1 }
    }

    /// Goes to the next line; false at the end, or if there is no room for more.
    fn advance(&mut self) -> bool {
        let mut joined = Vec::new();
        while let Some(mut line) = self.input.line() {
            self.number = self.next;
            self.next += 1;
            if line.ends_with(b"\\") {
                joined.clear();
                while let Some(begun) = line.strip_suffix(b"\\") {
                    joined.extend_from_slice(begun);
                    joined.push(b' ');
                    line = self.input.line().unwrap_or_default();
                    self.next += 1;
                }
                joined.extend_from_slice(line);
                line = &joined;
            }
            let mut words = words(line).take_while(|word| !word.starts_with(b"#"));
            let Some(name) = words.next() else { continue };
            let list = LISTS.iter().position(|(list, _)| *list == name);
            let most = match list {
                Some(1) => 2,
                Some(_) => 3,
                None if name == b"f" => usize::MAX,
                None if name == b"mtllib" => {
                    self.library = self.library.take().or_else(|| words.next().map(quote));
                    continue;
                }
                None => continue,
            };
            self.read = 0;
            self.line.clear();
            self.line.extend_from_slice(name);
            let mut count = 0;
            for word in words.take(most) {
                self.line.push(b' ');
                self.line.extend_from_slice(word);
                count += 1;
            }
            if list == Some(1) && count == 1 {
                self.line.extend_from_slice(b" 0");
            }
            self.line.push(b'\n');
            if let Some(count) = list.and_then(|list| self.counts.get_mut(list)) {
                *count += 1;
            }
            let bytes = if list.is_some() { ENTRY } else { FACE + CORNER * count };
            self.room = self.room.and_then(|room| room.checked_sub(bytes));
            return self.room.is_some();
        }
        false
    }

    /// Adds an entry to each empty list. The crate ignores references to an empty list; with an entry it reports them.
    fn fill_lists(&mut self) -> bool {
        while let (Some(count), Some((name, _))) = (self.counts.get(self.ended), LISTS.get(self.ended)) {
            self.ended += 1;
            if *count == 0 {
                self.read = 0;
                self.line.clear();
                self.line.extend_from_slice(name);
                self.line.extend_from_slice(b" 0 0 0\n");
                return true;
            }
        }
        false
    }
}

impl BufRead for Lines<'_, '_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.read >= self.line.len() && !self.advance() && !self.fill_lists() {
            return Ok(&[]);
        }
        Ok(self.line.get(self.read..).unwrap_or_default())
    }

    fn consume(&mut self, count: usize) {
        self.read += count;
    }
}

impl Read for Lines<'_, '_> {
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        let count = self.fill_buf()?.read(to)?;
        self.consume(count);
        Ok(count)
    }
}

/// The error in a refused file, with its position; none if it is not found.
fn fault(bytes: &[u8]) -> Option<String> {
    let mut tell = |_| {};
    let mut input = Input::new(bytes, &mut tell);
    let mut lines = Lines::new(&mut input);
    let mut face = 0_u64;
    // References of faces to entries that come later or never: the face, the list and the entry.
    let mut ahead: Vec<(u64, usize, u64)> = Vec::new();
    while lines.advance() {
        let mut words = words(&lines.line);
        let line = lines.number;
        if words.next() != Some(b"f") {
            let numbers: Vec<&[u8]> = words.collect();
            if let Some(word) = numbers.iter().find(|word| number::<f64>(word).is_none()) {
                return Some(format!("line {line}: expected a number, found {}", quote(word)));
            }
            let expected = if lines.line.starts_with(b"vt") { 2 } else { 3 };
            if numbers.len() < expected {
                return Some(format!("line {line}: expected {expected} numbers, found {}", numbers.len()));
            }
            continue;
        }
        for word in words {
            let Some(corner) = corner(word, &lines.counts) else {
                return Some(format!(
                    "line {line}: face {face} (counted from 0): expected a corner such as 5, 5/2, 5//3 or 5/2/3 that \
                     refers to what the file has, counted from 1, found {}",
                    quote(word)
                ));
            };
            for (list, (reference, count)) in corner.iter().zip(lines.counts).enumerate() {
                ahead.extend(reference.filter(|&reference| reference > count).map(|at| (face, list, at)));
            }
        }
        face += 1;
    }
    ahead.into_iter().find_map(|(face, list, entry)| {
        let (count, (_, what)) = (lines.counts.get(list)?, LISTS.get(list)?);
        (entry > *count).then(|| {
            format!("face {face} (counted from 0): there is no {what} {entry}; the file has {count}, counted from 1")
        })
    })
}

/// The references of a corner, counted from 1. Negative numbers count backwards from the last entry so far.
fn corner(word: &[u8], counts: &[u64; 3]) -> Option<[Option<u64>; 3]> {
    let mut parts = word.split(|&byte| byte == b'/');
    let mut corner = [None; 3];
    for (at, (to, &count)) in corner.iter_mut().zip(counts).enumerate() {
        *to = match parts.next() {
            None | Some(b"") if at > 0 => None,
            part => match number::<i64>(part?)? {
                back if back < 0 => Some(count.checked_sub(back.unsigned_abs())? + 1),
                0 => return None,
                index => Some(index as u64).filter(|&index| index <= u64::from(u32::MAX)),
            }
            .map(Some)?,
        };
    }
    parts.next().is_none().then_some(corner)
}

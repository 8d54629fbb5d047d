//! Wavefront OBJ: positions, texture coordinates, normals, faces, and the names of their materials.
//!
//! The reader is our own, because the crate `tobj` drops all texture coordinates if a face has none, and names no line. The lists are read
//! first, because faces may refer to what comes later.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::Path;

use glam::{DVec3, Vec2, Vec3};

use super::input::{Input, number, rest_of, words};
use crate::printable::quote;
use crate::scene::draft::{Draft, LARGEST};

/// The memory that reading a file may take beside its mesh: for an entry of a list, and for a vertex in the table of vertices.
const MOST_BYTES: usize = 5 << 29;
const ENTRY: usize = size_of::<DVec3>();
const VERTEX: usize = 2 * size_of::<(Vertex, u32)>();

/// A number of a part, and the references of a corner, counted from 1. 0 stands for none.
type Vertex = (u32, [u32; 3]);

/// A name in a file, with its line.
pub type Named = (String, u64);

/// The faces of one material. Those before the first material have none.
pub struct Part {
    pub material: Option<Named>,
    pub draft: Draft,
    /// Whether a corner has texture coordinates, and a normal.
    has: [bool; 2],
}

/// The contents of a file: its parts in the order of their first faces, and the files of materials that it names.
pub struct Contents {
    pub parts: Vec<Part>,
    pub libraries: Vec<Named>,
}

pub fn parse(_: &Path, input: &mut Input, draft: &mut Draft) -> Result<(), String> {
    let Contents { parts, libraries } = read(input, draft.room, false)?;
    if let Some(part) = parts.into_iter().next() {
        *draft = part.draft;
    }
    if let Some((library, _)) = libraries.first() {
        draft.warnings.push(format!(
            "its materials, in {} (mtllib), are not read: the mesh has the one that the scene gives it",
            quote(library)
        ));
    }
    Ok(())
}

/// Reads a file as one part, or as one for each material. All parts together may take `room` bytes.
pub fn read(input: &mut Input, room: usize, by_material: bool) -> Result<Contents, String> {
    let bytes = input.rest;
    let lists = Lists::new(bytes)?;
    let totals = lists.counts();
    let mut left = lists.left;
    let new_part = |material, room| Part { material, draft: Draft::new(room), has: [false; 2] };
    let (mut parts, mut libraries) = (vec![new_part(None, room)], Vec::new());
    let (mut by_name, mut numbers) = (HashMap::new(), HashMap::new());
    let (mut current, mut counts, mut face, mut corners) = (0, [0; 3], 0_u64, Vec::new());
    let mut lines = Lines::new(input);
    while lines.advance() {
        let (mut words, line) = (words(&lines.line), lines.number);
        let name = words.next().unwrap_or_default();
        if let Some(count) = list_of(name).and_then(|list| counts.get_mut(list)) {
            *count += 1;
        } else if name == b"mtllib" {
            libraries.push((rest_of(&lines.line), line));
        } else if name == b"usemtl" && by_material {
            let name = rest_of(&lines.line);
            let room = parts.get(current).map_or(0, |part| part.draft.room);
            current = *by_name.entry(name.clone()).or_insert(parts.len());
            match parts.get_mut(current) {
                Some(part) => part.draft.room = room,
                None => parts.push(new_part(Some((name, line)), room)),
            }
        } else if name == b"f" {
            let Some(part) = parts.get_mut(current) else { break };
            let wrong = |what: String| format!("line {line}: face {face} (counted from 0): {what}");
            corners.clear();
            for word in words.take_while(|word| !word.starts_with(b"#")) {
                let corner = corner(word, &counts).ok_or_else(|| {
                    let found = quote(word);
                    wrong(format!(
                        "expected a corner such as 5, 5/2, 5//3 or 5/2/3 that refers to what the file has, counted from 1, found {found}"
                    ))
                })?;
                for ((&reference, &count), (_, what)) in corner.iter().zip(&totals).zip(LISTS) {
                    if u64::from(reference) > count {
                        return Err(wrong(format!(
                            "there is no {what} {reference}; the file has {count}, counted from 1"
                        )));
                    }
                }
                corners.push(match numbers.entry((current as u32, corner)) {
                    Entry::Occupied(known) => *known.get(),
                    Entry::Vacant(new) => {
                        left = left.checked_sub(VERTEX).ok_or_else(no_memory)?;
                        *new.insert(part.add(corner, &lists, bytes)?)
                    }
                });
            }
            part.draft.face(&corners)?;
            face += 1;
        }
    }
    for part in &mut parts {
        let [has_uvs, has_normals] = part.has;
        part.draft.uvs.truncate(if has_uvs { usize::MAX } else { 0 });
        part.draft.normals.truncate(if has_normals { usize::MAX } else { 0 });
    }
    if by_material {
        parts.retain(|part| part.draft.face_count > 0);
    }
    if let Some(part) = parts.first_mut().filter(|_| lists.have_colours) {
        part.draft.warnings.push("the colours of its vertices are not read: save it as .ply or .glb".to_owned());
    }
    Ok(Contents { parts, libraries })
}

impl Part {
    /// Adds the vertex of a corner. What the corner lacks is not a number.
    fn add(&mut self, [position, uv, normal]: [u32; 3], lists: &Lists, bytes: &[u8]) -> Result<u32, String> {
        fn entry<T: Copy>(list: &[T], reference: u32) -> Option<T> {
            list.get((reference as usize).checked_sub(1)?).copied()
        }
        let draft = &mut self.draft;
        let position = entry(&lists.positions, position).unwrap_or(DVec3::NAN);
        if !position.abs().cmple(DVec3::splat(LARGEST)).all() {
            return Err(not_finite(bytes, 0));
        }
        let (uv, normal) = (entry(&lists.uvs, uv), entry(&lists.normals, normal));
        if uv.is_some_and(|uv| !uv.is_finite()) {
            draft.bad_uv.get_or_insert_with(|| not_finite(bytes, 1));
        }
        if normal.is_some_and(|normal| !normal.is_finite()) {
            draft.bad_normal.get_or_insert_with(|| not_finite(bytes, 2));
        }
        self.has = [self.has[0] || uv.is_some(), self.has[1] || normal.is_some()];
        draft.uvs.push(uv.unwrap_or(Vec2::NAN));
        draft.normals.push(normal.unwrap_or(Vec3::NAN));
        draft.vertex(position)
    }
}

fn no_memory() -> String {
    format!(
        "it takes more than {} MiB of memory to read: split it into several files, or save it as .ply or .glb",
        MOST_BYTES >> 20
    )
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
        if words.next().and_then(list_of) != Some(list) {
            continue;
        }
        let fits = |word: &&[u8]| number::<f64>(word).is_some_and(|number| number.abs() <= largest);
        if let Some(word) = words.take(if list == 1 { 2 } else { 3 }).find(|word| !fits(word)) {
            return format!("line {}: {expected}, found {}", lines.number, quote(word));
        }
    }
    expected
}

/// The lists of an OBJ file, in the order of a corner's references.
const LISTS: [(&[u8], &str); 3] = [(b"v", "position"), (b"vt", "pair of texture coordinates"), (b"vn", "normal")];

fn list_of(name: &[u8]) -> Option<usize> {
    LISTS.iter().position(|(list, _)| *list == name)
}

/// The entries of all lists.
struct Lists {
    positions: Vec<DVec3>,
    uvs: Vec<Vec2>,
    normals: Vec<Vec3>,
    /// Whether a position has a colour behind it.
    have_colours: bool,
    /// The bytes that are left for reading.
    left: usize,
}

impl Lists {
    fn new(bytes: &[u8]) -> Result<Lists, String> {
        let (positions, uvs, normals) = (Vec::new(), Vec::new(), Vec::new());
        let mut lists = Lists { positions, uvs, normals, have_colours: false, left: MOST_BYTES };
        let mut tell = |_| {};
        let mut input = Input::new(bytes, &mut tell);
        let mut lines = Lines::new(&mut input);
        while lines.advance() {
            let (words, line) = (words(&lines.line), lines.number);
            let mut words = words.take_while(|word| !word.starts_with(b"#"));
            let Some(list) = words.next().and_then(list_of) else { continue };
            lists.left = lists.left.checked_sub(ENTRY).ok_or_else(no_memory)?;
            let (mut numbers, mut count) = ([0.0; 3], 0);
            for (to, word) in numbers.iter_mut().zip(&mut words) {
                let found = || format!("line {line}: expected a number, found {}", quote(word));
                *to = number(word).ok_or_else(found)?;
                count += 1;
            }
            // Texture coordinates may be one number.
            if count < if list == 1 { 1 } else { 3 } {
                let expected = if list == 1 { 2 } else { 3 };
                return Err(format!("line {line}: expected {expected} numbers, found {count}"));
            }
            let vector = DVec3::from_array(numbers);
            match list {
                0 => {
                    lists.positions.push(vector);
                    lists.have_colours |= words.count() >= 3;
                }
                1 => lists.uvs.push(vector.truncate().as_vec2()),
                _ => lists.normals.push(vector.as_vec3()),
            }
        }
        Ok(lists)
    }

    fn counts(&self) -> [u64; 3] {
        [self.positions.len(), self.uvs.len(), self.normals.len()].map(|count| count as u64)
    }
}

/// The lines of a file, those joined that a backslash continues.
pub struct Lines<'a, 'b> {
    input: &'a mut Input<'b>,
    pub line: Vec<u8>,
    /// The line number at which the current line begins, and that of the next line.
    pub number: u64,
    next: u64,
}

impl<'a, 'b> Lines<'a, 'b> {
    pub fn new(input: &'a mut Input<'b>) -> Lines<'a, 'b> {
        Lines { input, line: Vec::new(), number: 0, next: 1 }
    }

    /// Goes to the next line; false at the end.
    pub fn advance(&mut self) -> bool {
        self.line.clear();
        self.number = self.next;
        while let Some(line) = self.input.line() {
            self.next += 1;
            match line.strip_suffix(b"\\") {
                Some(begun) => self.line.extend_from_slice(&[begun, b" "].concat()),
                None => {
                    self.line.extend_from_slice(line);
                    return true;
                }
            }
        }
        !self.line.is_empty()
    }
}

/// The references of a corner, counted from 1. Negative numbers count backwards from the last entry so far.
fn corner(word: &[u8], counts: &[u64; 3]) -> Option<[u32; 3]> {
    let mut parts = word.split(|&byte| byte == b'/');
    let mut corner = [0; 3];
    for (at, (to, &count)) in corner.iter_mut().zip(counts).enumerate() {
        *to = match parts.next() {
            None | Some(b"") if at > 0 => 0,
            part => match number::<i64>(part?)? {
                back if back < 0 => u32::try_from(count.checked_sub(back.unsigned_abs())? + 1).ok()?,
                0 => return None,
                index => u32::try_from(index).ok()?,
            },
        };
    }
    parts.next().is_none().then_some(corner)
}

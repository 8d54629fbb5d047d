//! PLY, as text and as binary of either byte order, with the crate `serde-ply`. Reads the elements `vertex` and `face`,
//! and skips all others.
//!
//! The crate hands out the numbers row by row and stores none. It reserves no memory for the counts in the header. It would ignore
//! unknown lines of the header, so these are refused before.

use std::fs::File;
use std::io::{ErrorKind, Read};
use std::iter::once;
use std::path::Path;

use glam::{DVec3, Vec2, Vec3};
use serde::de::{DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde_ply::{DeserializeError, ElementDef, PlyFormat, PlyHeader, PlyProperty, PlyReader, PropertyType, ScalarType};

use super::input::{Input, number, words};
use crate::bitmap::from_srgb;
use crate::guard::guarded;
use crate::printable::quote;
use crate::scene::draft::Draft;

/// Vertices are numbered in 32 bits.
const MOST_VERTICES: usize = u32::MAX as usize;
/// The largest length of a line in the header, in bytes.
const LONGEST_LINE: usize = 1 << 16;

pub fn parse(_: &Path, input: &mut Input, draft: &mut Draft) -> Result<(), String> {
    let text = header_text(input)?;
    let header = guarded(|| header(&text))??;
    for name in ["vertex", "face"] {
        if !header.has_element(name) {
            return Err(format!("expected an element {name} in its header"));
        }
    }
    guarded(|| payload(&text, &header, input, draft))?
}

/// The lines of the header, or of the file if the header does not end, as UTF-8. Comments may be in any encoding.
fn header_text(input: &mut Input) -> Result<String, String> {
    let mut text = String::new();
    let mut line_number = 0_u64;
    loop {
        line_number += 1;
        let Some(line) = input.line() else { return Ok(text) };
        let at_line = |reason: &str| Err(format!("line {line_number}: {reason}"));
        if line.len() > LONGEST_LINE {
            return at_line("expected a line of a PLY header, found one of more than 65536 bytes");
        }
        text.push_str(&String::from_utf8_lossy(line));
        text.push('\n');
        match words(line).collect::<Vec<_>>().as_slice() {
            [b"end_header"] => return Ok(text),
            [b"ply"] if line_number == 1 => {}
            _ if line_number == 1 => return at_line("expected ply, the first line of every PLY file"),
            [] | [b"format" | b"element" | b"property" | b"comment" | b"obj_info", ..] => {}
            [word, ..] => {
                return at_line(&format!(
                    "expected format, element, property, comment or end_header, found {}",
                    quote(word)
                ));
            }
        }
    }
}

fn header(text: &str) -> Result<PlyHeader, String> {
    let mut rest = text.as_bytes();
    let read = PlyReader::from_reader(&mut rest).map(|reader| reader.header().clone());
    read.map_err(|DeserializeError(error)| {
        if error.kind() == ErrorKind::UnexpectedEof {
            return "the file ends in its header: expected end_header".to_owned();
        }
        // The last line that the crate read.
        let lines = text.get(..text.len() - rest.len()).unwrap_or_default().lines();
        let number = lines.clone().count();
        let expected = match lines.last().and_then(|line| line.split_whitespace().next()) {
            Some("format") => "format ascii, binary_little_endian or binary_big_endian, and 1.0",
            Some("element") => "element NAME COUNT",
            Some("property") => {
                "an element before, and then property TYPE NAME or property list TYPE TYPE NAME of its properties"
            }
            _ => "a line such as format ascii 1.0 in its header",
        };
        format!("line {number}: expected {expected}: {error}")
    })
}

fn payload(text: &str, header: &PlyHeader, input: &mut Input, draft: &mut Draft) -> Result<(), String> {
    // The crate expects white space after every number in text.
    let end: &[u8] = if header.format == PlyFormat::Ascii { b"\n" } else { b"" };
    let rows = input.rest;
    let mut reader = PlyReader::from_reader(text.as_bytes().chain(&mut *input).chain(end))
        .map_err(|DeserializeError(error)| error.to_string())?;
    for element in &header.elem_defs {
        let ElementDef { name, count, .. } = element;
        let in_row = |row: usize, reason: String| Err(format!("{name} {row} (counted from 0): {reason}"));
        let mut elements = match Rows::new(element, draft) {
            Ok(elements) => elements,
            Err(reason) => return in_row(0, reason),
        };
        elements.reserve(header.format, rows.len());
        let mut element = &mut reader;
        let read = element.next_key::<IgnoredAny>().and_then(|_| element.next_value_seed(&mut elements));
        let Rows { row, wanted, wrong, .. } = elements;
        let Err(DeserializeError(error)) = read else { continue };
        if let Some(reason) = wrong {
            return in_row(row, reason);
        }
        if error.kind() == ErrorKind::UnexpectedEof {
            return Err(format!("the file ends in {name} {row} (counted from 0) of {count}: it is not complete"));
        }
        if header.format != PlyFormat::Ascii {
            return in_row(row, format!("expected {wanted}: {error}"));
        }
        // Text is read byte by byte, so that the wrong word is the last one.
        drop(reader);
        let read = rows.get(..rows.len() - input.rest.len()).unwrap_or_default();
        let word = read.trim_ascii_end().rsplit(u8::is_ascii_whitespace).next().unwrap_or_default();
        return in_row(
            row,
            match number::<f64>(word) {
                Some(value) => format!("expected {wanted}, found {value}"),
                None => format!("expected a number, found {}", quote(word)),
            },
        );
    }
    Ok(())
}

/// The use of a property.
#[derive(Clone, Copy, PartialEq)]
enum Column {
    /// One of the numbers of a vertex, by its index in `NAMES`.
    Number(usize),
    /// The list of a face's corners.
    Corners,
    /// Not used.
    Other,
}

/// The names of a vertex's numbers.
const NAMES: [&[&str]; 11] = [
    &["x"],
    &["y"],
    &["z"],
    &["nx"],
    &["ny"],
    &["nz"],
    &["u", "s", "texture_u", "texture_s"],
    &["v", "t", "texture_v", "texture_t"],
    &["red"],
    &["green"],
    &["blue"],
];

/// Whether the header of a file gives its vertices colours. What is broken is reported where the mesh is read.
pub fn has_colours(path: &Path) -> bool {
    let mut start = Vec::new();
    let read = File::open(path).and_then(|file| file.take(LONGEST_LINE as u64).read_to_end(&mut start));
    let mut tell = |_| {};
    let header = read.ok().and_then(|_| header(&header_text(&mut Input::new(&start, &mut tell)).ok()?).ok());
    let has = |element: &ElementDef| element.name == "vertex" && element.properties.iter().any(|it| it.name == "red");
    header.is_some_and(|header| header.elem_defs.iter().any(has))
}

/// Adds the rows of an element to the draft.
struct Rows<'a> {
    element: &'a ElementDef,
    columns: Vec<Column>,
    has_normals: bool,
    has_uvs: bool,
    /// The largest number of a colour, by the type of its red.
    full: Option<f64>,
    draft: &'a mut Draft,
    values: [f64; NAMES.len()],
    corners: Vec<u32>,
    /// The row that is being read, counted from 0.
    row: usize,
    /// The number that is being read, in words.
    wanted: &'static str,
    /// An error about the row that the crate does not detect.
    wrong: Option<String>,
}

const ANY: &str = "a number that its type can hold";
const COUNT: &str = "a number of corners";
const CORNER: &str = "the number of a vertex, counted from 0";

impl<'a> Rows<'a> {
    fn new(element: &'a ElementDef, draft: &'a mut Draft) -> Result<Rows<'a>, String> {
        let (is_vertex, is_face) = (element.name == "vertex", element.name == "face");
        let column = |property: &PlyProperty| {
            let name = property.name.as_str();
            let index = NAMES.iter().position(|names| names.contains(&name));
            match (&property.property_type, index) {
                (PropertyType::Scalar(_), Some(index)) if is_vertex => Column::Number(index),
                (PropertyType::List { .. }, _) if is_face && ["vertex_indices", "vertex_index"].contains(&name) => {
                    Column::Corners
                }
                _ => Column::Other,
            }
        };
        let columns: Vec<Column> = element.properties.iter().map(column).collect();
        let has = |mut indices: std::ops::Range<usize>| indices.all(|index| columns.contains(&Column::Number(index)));
        if is_vertex && !has(0..3) {
            return Err("expected the properties x, y and z".to_owned());
        }
        if is_vertex && element.count > MOST_VERTICES {
            return Err(format!("expected at most {MOST_VERTICES} vertices, found {}", element.count));
        }
        if is_face && !columns.contains(&Column::Corners) {
            return Err("expected a property list vertex_indices".to_owned());
        }
        let (has_normals, has_uvs) = (has(3..6), has(6..8));
        let red = element.properties.iter().find(|property| property.name == "red").filter(|_| has(8..11));
        let full = red.map(|red| match red.property_type {
            PropertyType::Scalar(ScalarType::U8) => f64::from(u8::MAX),
            PropertyType::Scalar(ScalarType::U16) => f64::from(u16::MAX),
            _ => 1.0,
        });
        Ok(Rows {
            element,
            columns,
            has_normals,
            has_uvs,
            full,
            draft,
            values: [0.0; NAMES.len()],
            corners: Vec::new(),
            row: 0,
            wanted: ANY,
            wrong: None,
        })
    }

    /// Reserves memory for the largest number of rows that fit into `bytes`, if lists have three entries.
    fn reserve(&mut self, format: PlyFormat, bytes: usize) {
        let is_text = format == PlyFormat::Ascii;
        let size = |kind: ScalarType| match kind {
            _ if is_text => 2,
            ScalarType::I8 | ScalarType::U8 => 1,
            ScalarType::I16 | ScalarType::U16 => 2,
            ScalarType::I32 | ScalarType::U32 | ScalarType::F32 => 4,
            ScalarType::F64 => 8,
        };
        let size = |property: &PlyProperty| match property.property_type {
            PropertyType::Scalar(kind) => size(kind),
            PropertyType::List { count_type, data_type } => size(count_type) + 3 * size(data_type),
        };
        let row: usize = self.element.properties.iter().map(size).sum();
        let rows = self.element.count.min(bytes / row.max(1) + 1);
        match self.element.name.as_str() {
            "vertex" => {
                let rows = rows.min(self.draft.most_vertices());
                self.draft.positions.reserve(rows);
                self.draft.normals.reserve(if self.has_normals { rows } else { 0 });
                self.draft.uvs.reserve(if self.has_uvs { rows } else { 0 });
            }
            "face" => self.draft.reserve(rows),
            _ => {}
        }
    }

    /// Adds the row that was read.
    fn add(&mut self) -> Result<(), String> {
        match self.element.name.as_str() {
            "vertex" => {
                let [x, y, z, nx, ny, nz, u, v, red, green, blue] = self.values;
                self.draft.vertex(DVec3::new(x, y, z))?;
                let row = self.row;
                if self.has_normals {
                    let normal = Vec3::new(nx as f32, ny as f32, nz as f32);
                    if !normal.is_finite() {
                        self.draft.bad_normal.get_or_insert_with(|| {
                            format!("vertex {row} (counted from 0): expected a finite normal, found ({nx}, {ny}, {nz})")
                        });
                    }
                    self.draft.normals.push(normal);
                }
                if self.has_uvs {
                    let uv = Vec2::new(u as f32, v as f32);
                    if !uv.is_finite() {
                        self.draft.bad_uv.get_or_insert_with(|| {
                            format!(
                                "vertex {row} (counted from 0): expected finite texture coordinates, found ({u}, {v})"
                            )
                        });
                    }
                    self.draft.uvs.push(uv);
                }
                if let Some(full) = self.full {
                    // They are sRGB, as those of pictures.
                    let code =
                        |value: f64| (from_srgb((value / full).clamp(0.0, 1.0)) * f32::from(u16::MAX)).round() as u16;
                    self.draft.colour(row, once([red, green, blue].map(code)))?;
                }
            }
            "face" => self.draft.face(&self.corners)?,
            _ => {}
        }
        self.row += 1;
        Ok(())
    }
}

/// Ends the reading with an error of this program.
fn refuse<T, E: Error>(wrong: &mut Option<String>, reason: String) -> Result<T, E> {
    *wrong = Some(reason);
    Err(E::custom(""))
}

/// The crate presents an element as a sequence.
impl<'de> DeserializeSeed<'de> for &mut Rows<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, rows: D) -> Result<(), D::Error> {
        rows.deserialize_seq(self)
    }
}

impl<'de> Visitor<'de> for &mut Rows<'_> {
    type Value = ();

    fn expecting(&self, to: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(to, "rows")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut rows: A) -> Result<(), A::Error> {
        // Rows without properties take no bytes. They are not read, because the header can claim any number of them.
        while !self.columns.is_empty() && rows.next_element_seed(Row(self))?.is_some() {}
        Ok(())
    }
}

/// The crate presents a row as a map.
struct Row<'a, 'b>(&'a mut Rows<'b>);

impl<'de> DeserializeSeed<'de> for Row<'_, '_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, row: D) -> Result<(), D::Error> {
        row.deserialize_map(self)
    }
}

impl<'de> Visitor<'de> for Row<'_, '_> {
    type Value = ();

    fn expecting(&self, to: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(to, "a row")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut row: A) -> Result<(), A::Error> {
        let Row(rows) = self;
        for &column in &rows.columns {
            rows.wanted = ANY;
            row.next_key::<IgnoredAny>()?;
            match column {
                Column::Number(index) => {
                    let value = row.next_value()?;
                    if let Some(to) = rows.values.get_mut(index) {
                        *to = value;
                    }
                }
                Column::Corners => {
                    rows.corners.clear();
                    rows.wanted = COUNT;
                    let corners =
                        Corners { corners: &mut rows.corners, wanted: &mut rows.wanted, wrong: &mut rows.wrong };
                    row.next_value_seed(corners)?;
                }
                Column::Other => drop(row.next_value::<IgnoredAny>()?),
            }
        }
        rows.add().or_else(|reason| refuse(&mut rows.wrong, reason))
    }
}

/// The crate presents a list as a sequence.
struct Corners<'a> {
    corners: &'a mut Vec<u32>,
    wanted: &'a mut &'static str,
    wrong: &'a mut Option<String>,
}

impl<'de> DeserializeSeed<'de> for Corners<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, list: D) -> Result<(), D::Error> {
        list.deserialize_seq(self)
    }
}

impl<'de> Visitor<'de> for Corners<'_> {
    type Value = ();

    fn expecting(&self, to: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(to, "a list")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<(), A::Error> {
        *self.wanted = CORNER;
        // f64 represents the numbers of all types exactly.
        while let Some(value) = list.next_element::<f64>()? {
            let corner = value as u32;
            if f64::from(corner) != value {
                return refuse(self.wrong, format!("expected {CORNER}, found {value}"));
            }
            self.corners.push(corner);
        }
        Ok(())
    }
}

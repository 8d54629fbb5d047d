//! PLY, as text and in binary of either order of bytes: the elements `vertex` and `face`; all others are passed over.

use std::path::Path;

use glam::{DVec3, Vec2, Vec3};

use super::draft::{Draft, MOST_VERTICES};
use super::input::{Input, number, quote, words};

/// Bytes of the longest line of a header.
const LONGEST_LINE: usize = 1 << 16;

#[derive(Clone, Copy, PartialEq)]
enum Format {
    Text,
    LittleEndian,
    BigEndian,
}

#[derive(Clone, Copy)]
enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

struct Property {
    name: String,
    /// Of the number of entries; a single number has none.
    count: Option<Kind>,
    kind: Kind,
}

struct Element {
    name: String,
    count: u64,
    properties: Vec<Property>,
}

pub fn parse(_: &Path, input: &mut Input) -> Result<Draft, String> {
    let (format, elements) = header(input)?;
    for name in ["vertex", "face"] {
        if !elements.iter().any(|element| element.name == name) {
            return Err(format!("expected an element {name} in its header"));
        }
    }
    let mut reader = Reader { input, format };
    let mut draft = Draft::default();
    for element in &elements {
        let mut row = 0;
        let read = match element.name.as_str() {
            "vertex" => reader.vertices(element, &mut draft, &mut row),
            "face" => reader.faces(element, &mut draft, &mut row),
            _ => reader.others(element, &mut row),
        };
        read.map_err(|wrong| match wrong {
            Wrong::End => {
                let Element { name, count, .. } = element;
                format!("the file ends in {name} {row} (counted from 0) of {count}: it is not complete")
            }
            Wrong::Words(words) => format!("{} {row} (counted from 0): {words}", element.name),
        })?;
    }
    Ok(draft)
}

fn header(input: &mut Input) -> Result<(Format, Vec<Element>), String> {
    let mut format = None;
    let mut elements: Vec<Element> = Vec::new();
    let mut line_number = 0_u64;
    loop {
        line_number += 1;
        let line = input.line().ok_or("the file ends in its header: expected end_header")?;
        let at_line = |reason: &str| Err(format!("line {line_number}: {reason}"));
        if line.len() > LONGEST_LINE {
            return at_line("expected a line of a PLY header, found one of more than 65536 bytes");
        }
        let words: Vec<&[u8]> = words(line).collect();
        if line_number == 1 {
            if words != [b"ply"] {
                return at_line("expected ply, the first line of every PLY file");
            }
            continue;
        }
        match words.as_slice() {
            [] | [b"comment" | b"obj_info", ..] => {}
            [b"format", b"ascii", ..] => format = Some(Format::Text),
            [b"format", b"binary_little_endian", ..] => format = Some(Format::LittleEndian),
            [b"format", b"binary_big_endian", ..] => format = Some(Format::BigEndian),
            [b"format", ..] => return at_line("expected format ascii, binary_little_endian or binary_big_endian"),
            [b"element", name, count] => {
                let Some(count) = number(count) else { return at_line("expected element NAME COUNT") };
                elements.push(Element { name: text(name), count, properties: Vec::new() });
            }
            [b"property", rest @ ..] => {
                let Some(property) = property(rest) else {
                    return at_line("expected property TYPE NAME or property list TYPE TYPE NAME");
                };
                match elements.last_mut() {
                    Some(element) => element.properties.push(property),
                    None => return at_line("expected an element before its properties"),
                }
            }
            [b"end_header"] => break,
            [word, ..] => {
                return at_line(&format!(
                    "expected format, element, property, comment or end_header, found {}",
                    quote(word)
                ));
            }
        }
    }
    let format = format.ok_or("expected a line such as format ascii 1.0 in its header")?;
    Ok((format, elements))
}

fn text(word: &[u8]) -> String {
    String::from_utf8_lossy(word).into_owned()
}

fn property(words: &[&[u8]]) -> Option<Property> {
    Some(match words {
        [b"list", count, kind, name] => {
            Property { name: text(name), count: Some(self::kind(count)?), kind: self::kind(kind)? }
        }
        [kind, name] => Property { name: text(name), count: None, kind: self::kind(kind)? },
        _ => return None,
    })
}

fn kind(word: &[u8]) -> Option<Kind> {
    Some(match word {
        b"char" | b"int8" => Kind::I8,
        b"uchar" | b"uint8" => Kind::U8,
        b"short" | b"int16" => Kind::I16,
        b"ushort" | b"uint16" => Kind::U16,
        b"int" | b"int32" => Kind::I32,
        b"uint" | b"uint32" => Kind::U32,
        b"float" | b"float32" => Kind::F32,
        b"double" | b"float64" => Kind::F64,
        _ => return None,
    })
}

impl Kind {
    fn bytes(self) -> usize {
        match self {
            Kind::I8 | Kind::U8 => 1,
            Kind::I16 | Kind::U16 => 2,
            Kind::I32 | Kind::U32 | Kind::F32 => 4,
            Kind::F64 => 8,
        }
    }
}

enum Wrong {
    /// The file ends.
    End,
    Words(String),
}

impl From<String> for Wrong {
    fn from(words: String) -> Wrong {
        Wrong::Words(words)
    }
}

struct Reader<'a, 'b> {
    input: &'a mut Input<'b>,
    format: Format,
}

impl Reader<'_, '_> {
    fn vertices(&mut self, element: &Element, draft: &mut Draft, row: &mut u64) -> Result<(), Wrong> {
        // Where each property goes: x, y, z, the normal, u, v; the last place is for all else.
        const NAMES: [&[&str]; 8] = [
            &["x"],
            &["y"],
            &["z"],
            &["nx"],
            &["ny"],
            &["nz"],
            &["u", "s", "texture_u", "texture_s"],
            &["v", "t", "texture_v", "texture_t"],
        ];
        let place = |property: &Property| {
            let found = NAMES.iter().position(|names| names.contains(&property.name.as_str()));
            found.filter(|_| property.count.is_none()).unwrap_or(NAMES.len())
        };
        let places: Vec<usize> = element.properties.iter().map(place).collect();
        let has = |range: std::ops::Range<usize>| range.into_iter().all(|place| places.contains(&place));
        let (has_normals, has_uvs) = (has(3..6), has(6..8));
        if !has(0..3) {
            return Err(Wrong::Words("expected the properties x, y and z".to_owned()));
        }
        if element.count > MOST_VERTICES as u64 {
            return Err(Wrong::Words(format!("expected at most {MOST_VERTICES} vertices, found {}", element.count)));
        }
        let room = self.rows_at_most(element);
        draft.positions.reserve(room);
        draft.normals.reserve(if has_normals { room } else { 0 });
        draft.uvs.reserve(if has_uvs { room } else { 0 });
        while *row < element.count {
            let mut values = [0.0; NAMES.len() + 1];
            for (property, &place) in element.properties.iter().zip(&places) {
                match property.count {
                    Some(count) => self.skip_list(count, property.kind)?,
                    None => {
                        let value = self.scalar(property.kind)?;
                        if let Some(to) = values.get_mut(place) {
                            *to = value;
                        }
                    }
                }
            }
            let [x, y, z, nx, ny, nz, u, v, _] = values;
            draft.vertex(DVec3::new(x, y, z))?;
            if has_normals {
                draft.normals.push(Vec3::new(nx as f32, ny as f32, nz as f32));
            }
            if has_uvs {
                draft.uvs.push(Vec2::new(u as f32, v as f32));
            }
            *row += 1;
        }
        Ok(())
    }

    fn faces(&mut self, element: &Element, draft: &mut Draft, row: &mut u64) -> Result<(), Wrong> {
        let is_corners = |property: &Property| {
            property.count.is_some() && ["vertex_indices", "vertex_index"].contains(&property.name.as_str())
        };
        let Some(corners_at) = element.properties.iter().position(is_corners) else {
            return Err(Wrong::Words("expected a property list vertex_indices".to_owned()));
        };
        draft.reserve(self.rows_at_most(element));
        let mut corners = Vec::new();
        while *row < element.count {
            for (at, property) in element.properties.iter().enumerate() {
                match property.count {
                    None => drop(self.scalar(property.kind)?),
                    Some(count) if at != corners_at => self.skip_list(count, property.kind)?,
                    Some(count) => {
                        corners.clear();
                        for _ in 0..self.whole(count, "a number of corners")? {
                            corners.push(self.whole(property.kind, "the number of a vertex, counted from 0")?);
                        }
                    }
                }
            }
            draft.face(&corners)?;
            *row += 1;
        }
        Ok(())
    }

    /// Passes over an element.
    fn others(&mut self, element: &Element, row: &mut u64) -> Result<(), Wrong> {
        // Rows of nothing have no end in the file, however many there are.
        while *row < element.count && !element.properties.is_empty() {
            for property in &element.properties {
                match property.count {
                    Some(count) => self.skip_list(count, property.kind)?,
                    None => drop(self.scalar(property.kind)?),
                }
            }
            *row += 1;
        }
        Ok(())
    }

    /// The rows of an element that there can be in the rest of the file, if lists have three entries.
    fn rows_at_most(&self, element: &Element) -> usize {
        let bytes = |property: &Property| match (self.format, property.count) {
            (Format::Text, None) => 2,
            (Format::Text, Some(_)) => 8,
            (_, None) => property.kind.bytes(),
            (_, Some(count)) => count.bytes() + 3 * property.kind.bytes(),
        };
        let row: usize = element.properties.iter().map(bytes).sum();
        let most = self.input.rest().len() / row.max(1) + 1;
        usize::try_from(element.count).map_or(most, |count| count.min(most))
    }

    fn skip_list(&mut self, count: Kind, kind: Kind) -> Result<(), Wrong> {
        let count = self.whole(count, "a number of entries")?;
        if self.format == Format::Text {
            return (0..count).try_for_each(|_| self.scalar(kind).map(drop));
        }
        let bytes = (count as usize).checked_mul(kind.bytes()).ok_or(Wrong::End)?;
        self.input.take(bytes).map(drop).ok_or(Wrong::End)
    }

    /// A number that counts or refers to something.
    fn whole(&mut self, kind: Kind, what: &str) -> Result<u32, Wrong> {
        let value = self.scalar(kind)?;
        let whole = value as u32;
        if f64::from(whole) == value {
            return Ok(whole);
        }
        Err(Wrong::Words(format!("expected {what}, found {value}")))
    }

    /// The next number. f64 holds all kinds exactly.
    fn scalar(&mut self, kind: Kind) -> Result<f64, Wrong> {
        if self.format == Format::Text {
            let word = self.input.word().ok_or(Wrong::End)?;
            return number(word).ok_or_else(|| Wrong::Words(format!("expected a number, found {}", quote(word))));
        }
        let value = match kind {
            Kind::I8 => self.array().map(|bytes| f64::from(i8::from_le_bytes(bytes))),
            Kind::U8 => self.array().map(|bytes| f64::from(u8::from_le_bytes(bytes))),
            Kind::I16 => self.array().map(|bytes| f64::from(i16::from_le_bytes(bytes))),
            Kind::U16 => self.array().map(|bytes| f64::from(u16::from_le_bytes(bytes))),
            Kind::I32 => self.array().map(|bytes| f64::from(i32::from_le_bytes(bytes))),
            Kind::U32 => self.array().map(|bytes| f64::from(u32::from_le_bytes(bytes))),
            Kind::F32 => self.array().map(|bytes| f64::from(f32::from_le_bytes(bytes))),
            Kind::F64 => self.array().map(f64::from_le_bytes),
        };
        value.ok_or(Wrong::End)
    }

    /// The next bytes, the lowest first.
    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let mut bytes = self.input.array()?;
        if self.format == Format::BigEndian {
            bytes.reverse();
        }
        Some(bytes)
    }
}

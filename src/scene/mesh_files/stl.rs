//! STL, as text and as binary: triangles without anything else. Corners at one position are one vertex.

use std::collections::HashMap;
use std::path::Path;

use glam::DVec3;

use super::input::{Input, number, words};
use crate::printable::quote;
use crate::scene::draft::Draft;

/// The bytes before the triangles of a binary file, whose last four are the number of triangles; and those of a triangle.
const HEADER: usize = 84;
const TRIANGLE: usize = 50;

pub fn parse(_: &Path, input: &mut Input, draft: &mut Draft) -> Result<(), String> {
    let bytes = input.rest;
    // Some programs begin a binary file with the word of a text.
    let is_text = bytes.starts_with(b"solid") && bytes.iter().take(HEADER).all(|byte| byte.is_ascii() && *byte != 0);
    let count = bytes.get(HEADER - 4..HEADER).and_then(|count| count.try_into().ok()).map(u32::from_le_bytes);
    let expected = count.map(|count| HEADER + TRIANGLE * count as usize);
    let mut vertices = Vertices(HashMap::new());
    match (count, expected) {
        (Some(_), Some(expected)) if expected == bytes.len() || !is_text => {
            if bytes.len() < expected {
                let (count, found) = (count.unwrap_or_default(), bytes.len());
                return Err(format!(
                    "its header says {count} triangles, which take {expected} bytes, and it has {found}"
                ));
            }
            let rest = bytes.len() - expected;
            if rest > 0 {
                draft.warnings.push(format!("{rest} bytes after its triangles are not read"));
            }
            draft.reserve(count.unwrap_or_default() as usize);
            input.take(HEADER);
            while input.rest.len() > rest
                && let Some(triangle) = input.take(TRIANGLE)
            {
                // A normal comes first, which the corners give too.
                let floats: Vec<f64> =
                    triangle.as_chunks().0.iter().skip(3).map(|bytes| f64::from(f32::from_le_bytes(*bytes))).collect();
                let mut corners = Vec::new();
                for &corner in floats.as_chunks().0 {
                    corners.push(vertices.number(corner, draft)?);
                }
                draft.face(&corners)?;
            }
            Ok(())
        }
        _ if is_text => text(input, &mut vertices, draft),
        _ => Err(format!(
            "expected solid, the first word of a text, or a header of {HEADER} bytes, found {} bytes",
            bytes.len()
        )),
    }
}

fn text(input: &mut Input, vertices: &mut Vertices, draft: &mut Draft) -> Result<(), String> {
    let (mut line_number, mut corners) = (0_u64, Vec::new());
    while let Some(line) = input.line() {
        line_number += 1;
        let mut words = words(line);
        let Some(first) = words.next() else { continue };
        match first.to_ascii_lowercase().as_slice() {
            b"vertex" => {
                let wrong = || format!("line {line_number}: expected vertex and three numbers, found {}", quote(line));
                let numbers: Option<Vec<f64>> = words.map(number).collect();
                let position = numbers.and_then(|numbers| numbers.try_into().ok()).ok_or_else(wrong)?;
                corners.push(vertices.number(position, draft)?);
            }
            b"endloop" => {
                if corners.len() < 3 {
                    return Err(format!(
                        "line {line_number}: expected three vertices before endloop, found {}",
                        corners.len()
                    ));
                }
                draft.face(&corners)?;
                corners.clear();
            }
            b"solid" | b"facet" | b"outer" | b"endfacet" | b"endsolid" => {}
            _ => {
                return Err(format!(
                    "line {line_number}: expected solid, facet, outer loop, vertex, endloop, endfacet or endsolid, found {}",
                    quote(first)
                ));
            }
        }
    }
    match corners.is_empty() {
        true => Ok(()),
        false => Err(format!("line {line_number}: it ends within a facet: it is not complete")),
    }
}

/// The numbers of vertices by their positions.
struct Vertices(HashMap<[u64; 3], u32>);

impl Vertices {
    fn number(&mut self, position: [f64; 3], draft: &mut Draft) -> Result<u32, String> {
        // 0 and -0 are one position.
        let key = position.map(|x| (x + 0.0).to_bits());
        if let Some(number) = self.0.get(&key) {
            return Ok(*number);
        }
        let number = draft.vertex(DVec3::from_array(position))?;
        self.0.insert(key, number);
        Ok(number)
    }
}

//! The attributes in the headers of an EXR, byte by byte, by "The OpenEXR file layout", and gpu-rt's checksum of them.

use std::ops::Range;

/// An attribute, and where its bytes are in the file.
#[derive(Clone, Debug)]
pub struct Field {
    /// The number of the part.
    pub part: usize,
    pub name: Range<usize>,
    pub kind: Range<usize>,
    /// Four bytes, low first.
    pub size: Range<usize>,
    pub value: Range<usize>,
}

impl Field {
    pub fn name_in<'a>(&self, bytes: &'a [u8]) -> &'a str {
        std::str::from_utf8(&bytes[self.name.clone()]).expect("UTF-8")
    }
}

/// The attributes of a file of several parts.
pub fn fields(bytes: &[u8]) -> Vec<Field> {
    let text = |start: usize| {
        let length = bytes[start..].iter().position(|byte| *byte == 0).expect("a zero ends it");
        start..start + length
    };
    let (mut fields, mut part, mut at) = (Vec::new(), 0, 8);
    // An empty name ends a header, and another one ends all.
    while bytes[at] != 0 {
        while bytes[at] != 0 {
            let name = text(at);
            let kind = text(name.end + 1);
            let size = kind.end + 1..kind.end + 5;
            let length = u32::from_le_bytes(bytes[size.clone()].try_into().expect("four bytes")) as usize;
            let value = size.end..size.end + length;
            at = value.end;
            fields.push(Field { part, name, kind, size, value });
        }
        (part, at) = (part + 1, at + 1);
    }
    fields
}

/// The attribute of this name in a part.
pub fn field(bytes: &[u8], part: usize, name: &str) -> Field {
    let found = fields(bytes).into_iter().find(|field| field.part == part && field.name_in(bytes) == name);
    found.unwrap_or_else(|| panic!("part {part} has no {name}"))
}

/// The file with the checksum of the header that it has.
pub fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let state = field(&bytes, 1, "gpu-rt:state").value;
    let mut hasher = crc32fast::Hasher::new();
    let mut add = |kind: &str, value: &[u8]| {
        hasher.update(kind.as_bytes());
        hasher.update(&(value.len() as u64).to_le_bytes());
        hasher.update(value);
    };
    add("text", &bytes[state]);
    let mut ours = fields(&bytes);
    ours.retain(|field| field.part == 0 && field.name_in(&bytes).starts_with("gpu-rt:"));
    ours.sort_by_key(|field| field.name_in(&bytes));
    for field in ours {
        add("name", &bytes[field.name.clone()]);
        let value = &bytes[field.value.clone()];
        match &bytes[field.kind.clone()] {
            b"string" => add("text", value),
            b"int" => add("int", &i64::from(i32::from_le_bytes(value.try_into().expect("four bytes"))).to_le_bytes()),
            b"double" => add("float", value),
            other => panic!("{}", String::from_utf8_lossy(other)),
        }
    }
    let checksum = field(&bytes, 1, "gpu-rt:checksum").value;
    bytes[checksum].copy_from_slice(format!("{:08x}", hasher.finalize()).as_bytes());
    bytes
}

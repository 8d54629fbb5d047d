//! What a file's header holds: attributes and their text, and the names that this program gives channels and parts.

use std::io;

use ::exr::meta::attribute::{AttributeValue, Text};
use ::exr::meta::header::LayerAttributes;

use crate::data::Rgb;

/// The channels of the variance of each pixel's mean.
pub(super) const VARIANCES: Rgb<&str> = ["variance.R", "variance.G", "variance.B"];
pub(super) const SAMPLES: &str = "samples.Y";
pub(super) const REJECTED: &str = "rejected.Y";
/// The name of the part that holds the state of the render, and of the attribute there that describes it.
pub(super) const STATE: &str = "gpu-rt:state";
/// The attribute beside it with the checksum of the header.
pub(super) const CHECKSUM: &str = "gpu-rt:checksum";
/// How the names of all attributes of this program begin.
const OURS: &str = "gpu-rt:";

/// The attribute that names the denoiser of a denoised image.
pub const DENOISER: &str = "gpu-rt:denoiser";

/// A setting or a result in the file's header.
#[derive(Clone, Debug, PartialEq)]
pub enum Attribute {
    /// Written as UTF-8.
    Text(String),
    /// Written as EXR's 32-bit integer, or as text if it needs more bits.
    Int(i64),
    /// Written as EXR's 64-bit float.
    Float(f64),
}

/// The attribute of this name.
pub fn attribute<'a>(attributes: &'a [(String, Attribute)], name: &str) -> Option<&'a Attribute> {
    attributes.iter().find(|(known, _)| known == name).map(|(_, value)| value)
}

/// The text of this name; empty where there is none.
pub fn attribute_text(attributes: &[(String, Attribute)], name: &str) -> String {
    match attribute(attributes, name) {
        Some(Attribute::Text(text)) => text.clone(),
        _ => String::new(),
    }
}

impl Attribute {
    pub(super) fn to_exr(&self) -> AttributeValue {
        match self {
            Attribute::Text(value) => AttributeValue::Text(text(value)),
            Attribute::Int(value) => match i32::try_from(*value) {
                Ok(value) => AttributeValue::I32(value),
                Err(_) => AttributeValue::Text(text(&value.to_string())),
            },
            Attribute::Float(value) => AttributeValue::F64(*value),
        }
    }

    /// An attribute of a file; nothing for kinds that this program does not write.
    pub(super) fn of_exr(value: &AttributeValue) -> Option<Attribute> {
        match value {
            AttributeValue::Text(value) => Some(Attribute::Text(decoded(value))),
            AttributeValue::I32(value) => Some(Attribute::Int(i64::from(*value))),
            AttributeValue::F32(value) => Some(Attribute::Float(f64::from(*value))),
            AttributeValue::F64(value) => Some(Attribute::Float(*value)),
            _ => None,
        }
    }
}

/// The checksum of what a file says of its render: the text of its state, and this program's attributes of the picture, which `merge` hands
/// on. Attributes of the standard and of other programs are not among them: they may change, and nothing goes on from them.
pub(super) fn checksum(state: &str, picture: &LayerAttributes) -> String {
    let mut ours: Vec<_> =
        picture.other.iter().filter(|(name, _)| name.as_slice().starts_with(OURS.as_bytes())).collect();
    ours.sort_by_key(|(name, _)| name.as_slice());
    let mut checksum = crc32fast::Hasher::new();
    let mut add = |kind: &[u8], bytes: &[u8]| {
        [kind, &(bytes.len() as u64).to_le_bytes(), bytes].into_iter().for_each(|bytes| checksum.update(bytes));
    };
    add(b"text", state.as_bytes());
    for (name, value) in ours {
        add(b"name", name.as_slice());
        match Attribute::of_exr(value) {
            Some(Attribute::Text(text)) => add(b"text", text.as_bytes()),
            Some(Attribute::Int(number)) => add(b"int", &number.to_le_bytes()),
            Some(Attribute::Float(number)) => add(b"float", &number.to_le_bytes()),
            None => {}
        }
    }
    format!("{:08x}", checksum.finalize())
}

/// EXR's text is bytes, by convention UTF-8. The crate's own conversion supports only Latin-1.
pub(super) fn text(value: &str) -> Text {
    Text::from_slice_unchecked(value.as_bytes())
}

pub(super) fn decoded(text: &Text) -> String {
    String::from_utf8_lossy(text.as_slice()).into_owned()
}

pub(super) fn to_io(error: ::exr::error::Error) -> io::Error {
    match error {
        ::exr::error::Error::Io(error) => error,
        other => io::Error::other(other.to_string()),
    }
}

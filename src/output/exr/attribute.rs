//! What a file's header holds: attributes and their text, and the names that this program gives channels and parts.

use std::io;

use ::exr::meta::attribute::{AttributeValue, Text};

use crate::data::Rgb;

/// The channels of the variance of each pixel's mean.
pub(super) const VARIANCES: Rgb<&str> = ["variance.R", "variance.G", "variance.B"];
pub(super) const SAMPLES: &str = "samples.Y";
pub(super) const REJECTED: &str = "rejected.Y";
/// The name of the part that holds the state of the render, and of the attribute there that describes it.
pub(super) const STATE: &str = "gpu-rt:state";

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

//! The properties of an element: each is asked for by its name, and those that nobody asks for are errors.

use std::cell::RefCell;

use glam::DVec3;

use super::document::Node;
use super::{Reader, transform};
use crate::error::{Error, Result};
use crate::printable::quote;
use crate::scene::types::Colour;
use glam::DAffine3;

/// The properties of an element.
pub struct Properties<'a> {
    pub node: &'a Node,
    used: RefCell<Vec<bool>>,
}

impl<'a> Properties<'a> {
    pub fn of(node: &'a Node) -> Properties<'a> {
        Properties { node, used: RefCell::new(vec![false; node.children.len()]) }
    }

    /// The type of the plugin.
    pub fn kind(&self) -> Result<&'a str> {
        self.node.required("type")
    }

    /// The children that fit, which now count as used.
    pub fn take(&self, fits: impl Fn(&Node) -> bool) -> Vec<&'a Node> {
        let mut used = self.used.borrow_mut();
        let all = self.node.children.iter().zip(used.iter_mut()).filter(|(child, _)| fits(child));
        all.map(|(child, used)| {
            *used = true;
            child
        })
        .collect()
    }

    pub fn find(&self, name: &str) -> Option<&'a Node> {
        self.take(|child| child.attribute("name") == Some(name)).pop()
    }

    /// Properties that do not change the image.
    pub fn ignore(&self, names: &[&str]) {
        names.iter().for_each(|name| _ = self.find(name));
    }

    fn value<T>(&self, name: &str, tags: &[&str], read: impl Fn(&'a Node) -> Result<T>) -> Result<Option<T>> {
        let Some(child) = self.find(name) else { return Ok(None) };
        match tags.contains(&child.tag.as_str()) {
            true => read(child).map(Some),
            false => Err(child.error(format!("expected <{}> here, found <{}>", tags.join("> or <"), child.tag))),
        }
    }

    pub fn number(&self, name: &str) -> Result<Option<f64>> {
        self.value(name, &["float", "integer"], |child| number(child, "value"))
    }

    pub fn number_or(&self, name: &str, default: f64) -> Result<f64> {
        Ok(self.number(name)?.unwrap_or(default))
    }

    pub fn integer_or(&self, name: &str, default: i64) -> Result<i64> {
        let read = |child: &Node| {
            let text = child.required("value")?;
            text.trim()
                .parse()
                .map_err(|_| child.error_at("value", format!("expected an integer, found {}", quote(text))))
        };
        Ok(self.value(name, &["integer"], read)?.unwrap_or(default))
    }

    pub fn flag_or(&self, name: &str, default: bool) -> Result<bool> {
        let read = |child: &Node| match child.required("value")?.to_ascii_lowercase().as_str() {
            "true" => Ok(true),
            "false" => Ok(false),
            other => Err(child.error_at("value", format!("expected true or false, found {}", quote(other)))),
        };
        Ok(self.value(name, &["boolean"], read)?.unwrap_or(default))
    }

    pub fn word(&self, name: &str) -> Result<Option<&'a str>> {
        self.value(name, &["string"], |child| child.required("value"))
    }

    pub fn vector(&self, name: &str) -> Result<Option<DVec3>> {
        self.value(name, &["point", "vector"], |child| vector(child, 0.0))
    }

    pub fn transform(&self, name: &str) -> Result<DAffine3> {
        Ok(self.value(name, &["transform"], transform::of)?.unwrap_or(DAffine3::IDENTITY))
    }

    pub fn colour_or(&self, name: &str, default: f64) -> Result<Colour> {
        Ok(self.value(name, &["rgb", "spectrum", "float", "integer"], colour)?.unwrap_or(Colour::splat(default)))
    }

    /// Refuses the properties that nobody has asked for.
    pub fn end(&self, reader: &mut Reader) {
        for (child, used) in self.node.children.iter().zip(self.used.borrow().iter()) {
            if !used {
                let message = format!(
                    "this property of {} is not read: remove it if the image does not need it",
                    self.node.title()
                );
                reader.findings.refuse(child.error(message));
            }
        }
    }
}

pub fn unknown(node: &Node, known: &str) -> Error {
    node.error_at("type", format!("this plugin is not read: expected one of {known}"))
}

pub fn number(node: &Node, name: &str) -> Result<f64> {
    let text = node.required(name)?;
    let found = text.trim().parse::<f64>().ok().filter(|number| number.is_finite());
    found.ok_or_else(|| node.error_at(name, format!("expected a number, found {}", quote(text))))
}

/// The numbers of an attribute, with spaces or commas between them.
pub fn numbers(node: &Node, name: &str) -> Result<Vec<f64>> {
    let text = node.required(name)?;
    let words = text.split([',', ' ', '\t', '\n', '\r']).filter(|word| !word.is_empty());
    let read = |word: &str| word.parse::<f64>().ok().filter(|number| number.is_finite());
    let all: Option<Vec<f64>> = words.map(read).collect();
    all.ok_or_else(|| node.error_at(name, format!("expected numbers, found {}", quote(text))))
}

/// The point of an attribute.
pub fn point(node: &Node, name: &str) -> Result<DVec3> {
    match numbers(node, name)?[..] {
        [x, y, z] => Ok(DVec3::new(x, y, z)),
        ref other => Err(node.error_at(name, format!("expected three numbers, found {}", other.len()))),
    }
}

/// x, y and z of an element, or its `value`. What is left out has the default.
pub fn vector(node: &Node, default: f64) -> Result<DVec3> {
    if node.attribute("value").is_some() {
        return match numbers(node, "value")?[..] {
            [x] => Ok(DVec3::splat(x)),
            _ => point(node, "value"),
        };
    }
    let axis = |name: &str| if node.attribute(name).is_some() { number(node, name) } else { Ok(default) };
    Ok(DVec3::new(axis("x")?, axis("y")?, axis("z")?))
}

/// The colour of an element, linear Rec. 709.
pub fn colour(node: &Node) -> Result<Colour> {
    if let Some(name) = node.attribute("type") {
        return Err(node.error_at("type", format!("the spectrum {name} is not read: give an <rgb> instead")));
    }
    if node.attribute("filename").is_some() {
        return Err(node.error_at("filename", "spectra by wavelengths are not read: give an <rgb> instead"));
    }
    let text = node.required("value")?.trim();
    if let Some(digits) = text.strip_prefix('#') {
        let code = u32::from_str_radix(digits, 16).ok().filter(|_| digits.len() == 6);
        let code = code.ok_or_else(|| node.error_at("value", format!("expected #rrggbb, found {}", quote(text))))?;
        let channel = |shift: u32| linear(f64::from(code >> shift & 255) / 255.0);
        return Ok(Colour::new(channel(16), channel(8), channel(0)));
    }
    if text.contains(':') {
        return Err(node.error_at("value", "spectra by wavelengths are not read: give an <rgb> instead"));
    }
    match numbers(node, "value")?[..] {
        [grey] => Ok(Colour::splat(grey)),
        [r, g, b] if node.tag == "rgb" => Ok(Colour::new(r, g, b)),
        _ => {
            Err(node
                .error_at("value", format!("expected one number{}", if node.tag == "rgb" { " or three" } else { "" })))
        }
    }
}

/// sRGB's transfer function.
fn linear(code: f64) -> f64 {
    if code <= 0.04045 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) }
}

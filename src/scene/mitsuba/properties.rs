//! The properties of an element: each is asked for by its name, and those that nobody asks for are errors.

use std::cell::RefCell;
use std::collections::HashSet;

use glam::{DAffine3, DVec3};

use super::document::Node;
use super::reader::Reader;
use super::transform;
use super::values::{colour, number, vector};
use crate::error::{Error, Result, require};
use crate::printable::quote;
use crate::scene::types::Colour;

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

    /// The type of the plugin, which is one of these.
    pub fn kind_among(&self, known: &[&str]) -> Result<&'a str> {
        let kind = self.kind()?;
        require(known.contains(&kind), || unknown(self.node, &known.join(", ")))?;
        Ok(kind)
    }

    /// The children that fit, which now count as used.
    pub fn take(&self, fits: impl Fn(&'a Node) -> bool) -> Vec<&'a Node> {
        let mut used = self.used.borrow_mut();
        let all = self.node.children.iter().zip(used.iter_mut()).filter(|(child, _)| fits(child));
        all.map(|(child, used)| {
            *used = true;
            child
        })
        .collect()
    }

    /// The elements of a tag in it, or that it refers to.
    pub fn elements(&self, tag: &str, reader: &Reader<'a, '_>) -> Result<Vec<&'a Node>> {
        let children = self.node.children.iter();
        children.filter(|child| child.tag == "ref").try_for_each(|child| reader.target(child).map(drop))?;
        let found = |child: &'a Node| reader.follow(child, tag).ok();
        Ok(self.take(|child| found(child).is_some()).into_iter().filter_map(found).collect())
    }

    pub fn find(&self, name: &str) -> Option<&'a Node> {
        self.take(|child| child.attribute("name") == Some(name)).pop()
    }

    pub fn has(&self, name: &str) -> bool {
        self.node.children.iter().any(|child| child.attribute("name") == Some(name))
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
        let mut names = HashSet::new();
        for (child, used) in self.node.children.iter().zip(self.used.borrow().iter()) {
            if child.attribute("name").is_some_and(|name| !names.insert(name)) {
                reader.made.findings.refuse(child.error("this property is there already: expected it once"));
            } else if !used {
                let title = self.node.title();
                reader.made.findings.refuse(match reader.target(child) {
                    Ok(found) if child.tag == "ref" => child.error(format!("{} has no place here", found.title())),
                    Err(missing) => missing,
                    Ok(_) => child.error(format!(
                        "this property of {title} is not read: remove it if the image does not need it"
                    )),
                });
            }
        }
    }
}

pub fn unknown(node: &Node, known: &str) -> Error {
    node.error_at("type", format!("this plugin is not read: expected one of {known}"))
}

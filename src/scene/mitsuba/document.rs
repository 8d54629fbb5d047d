//! The elements of a scene with their places: included files are in place, and names such as $spp are replaced.

use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use roxmltree::{Document, ParsingOptions};

use crate::error::{Error, Result, require};
use crate::printable::quote;
use crate::scene::imported::files::{self, Includes};
use crate::scene::imported::{Imported, Place, spectrum};

/// How deep elements may be nested, included files with them.
pub const DEEPEST: usize = 100;

/// The longest value, in bytes, once names are replaced in it.
const LONGEST_VALUE: usize = 1 << 16;

pub struct Attribute {
    pub name: String,
    pub value: String,
    at: Place,
}

pub struct Node {
    pub tag: String,
    pub attributes: Vec<Attribute>,
    pub children: Vec<Node>,
    pub at: Place,
}

impl Node {
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|attribute| attribute.name == name).map(|attribute| attribute.value.as_str())
    }

    /// The attribute, which must be there.
    pub fn required(&self, name: &str) -> Result<&str> {
        self.attribute(name).ok_or_else(|| self.error(format!("expected the attribute {name}")))
    }

    /// What it is: "bsdf diffuse", or "float alpha".
    pub fn title(&self) -> String {
        let word = self.attribute("type").or(self.attribute("name")).or(self.attribute("id"));
        word.map_or(self.tag.clone(), |word| format!("{} {word}", self.tag))
    }

    pub fn error(&self, message: impl Into<String>) -> Error {
        self.at.error(&self.title(), message)
    }

    /// An error at an attribute, or at the element if it is not there.
    pub fn error_at(&self, name: &str, message: impl Into<String>) -> Error {
        let at = self.attributes.iter().find(|attribute| attribute.name == name).map_or(&self.at, |found| &found.at);
        at.error(&format!("{}.{name}", self.title()), message)
    }
}

/// What reads the files of a scene.
pub struct Loader<'l, 'm> {
    /// The values of names: those of the command line, then those of `default`.
    names: BTreeMap<String, String>,
    used: BTreeSet<String>,
    /// Folders in which files are searched for.
    pub folders: Vec<PathBuf>,
    includes: Includes,
    made: &'l mut Imported<'m>,
}

impl<'l, 'm> Loader<'l, 'm> {
    pub fn new(path: &Path, defines: &[(String, String)], made: &'l mut Imported<'m>) -> Loader<'l, 'm> {
        Loader {
            names: defines.iter().cloned().collect(),
            used: BTreeSet::new(),
            folders: vec![path.parent().unwrap_or(Path::new("")).to_owned()],
            includes: Includes::new(path),
            made,
        }
    }

    /// The first of the names of the command line that the scene does not use.
    pub fn unused<'b>(&self, defines: &'b [(String, String)]) -> Option<&'b str> {
        defines.iter().map(|(name, _)| name.as_str()).find(|name| !self.used.contains(*name))
    }

    /// The root element of a file. `old`: whether names are of Mitsuba before 2, unless the file says its version.
    pub fn load(&mut self, path: &Path, depth: usize, old: bool) -> Result<Node> {
        let text = files::text(path, self.made.assets)?;
        let options = ParsingOptions { allow_dtd: false, ..ParsingOptions::default() };
        let document = Document::parse_with_options(&text, options).map_err(|error| {
            let at = Place { file: path.into(), line: error.pos().row, column: error.pos().col };
            match error {
                roxmltree::Error::DtdDetected => at.error("XML", "a DTD is not read: remove <!DOCTYPE ..>"),
                _ => at.error("XML", format!("expected XML: {error}")),
            }
        })?;
        let text = Text { path: path.into(), text: &text, last: Cell::new((0, 1, 1)) };
        let root = document.root_element();
        let at = text.place(root.range().start);
        let is_scene = depth > 0 || root.tag_name().name() == "scene";
        require(is_scene, || at.error("scene", "expected the element scene at the top of the file"))?;
        let old = match root.attribute("version").map(|version| (version, version.split('.').next())) {
            None if depth == 0 => return Err(at.error("scene", "expected the attribute version")),
            None => old,
            Some((version, major)) => match major.and_then(|word| word.parse::<u32>().ok()) {
                Some(major @ 0..=3) => major < 2,
                _ => return Err(at.error("scene", format!("expected a version from 0 to 3, found {}", quote(version)))),
            },
        };
        self.node(root, &text, depth, old)
    }

    fn node(&mut self, element: roxmltree::Node, text: &Text, depth: usize, old: bool) -> Result<Node> {
        let at = text.place(element.range().start);
        let mut node =
            Node { tag: element.tag_name().name().to_owned(), attributes: Vec::new(), children: Vec::new(), at };
        for attribute in element.attributes() {
            let (name, at) = (attribute.name().to_owned(), text.place(attribute.range().start));
            let wrong = |reason: String| at.error(&format!("{}.{name}", node.title()), reason);
            let value = self.replaced(attribute.value()).map_err(wrong)?;
            let is_name = name == "name" && node.tag != "default";
            let value = if old && is_name { snake_case(&value) } else { value };
            node.attributes.push(Attribute { name, value, at });
        }
        let file = match node.tag == "path" || node.attribute("name") == Some("filename") {
            true => node.attribute("value"),
            false => node.attribute("filename"),
        };
        self.made.notes.extend(file.and_then(|file| outside(file, &node)));
        if node.tag == "spectrum" && node.attribute("filename").is_some() {
            let pairs = self.spectrum(&node)?;
            node.attributes.push(Attribute { name: "value".to_owned(), value: pairs, at: node.at.clone() });
        }
        require(depth <= DEEPEST, || node.error(format!("expected at most {DEEPEST} elements within each other")))?;
        node.tag = match node.tag.as_str() {
            "lookAt" => "lookat".to_owned(),
            "color" => "rgb".to_owned(),
            tag => tag.to_owned(),
        };
        for child in element.children() {
            if !child.is_element() {
                continue;
            }
            let child = self.node(child, text, depth + 1, old)?;
            match child.tag.as_str() {
                "default" => {
                    let (name, value) = (child.required("name")?.to_owned(), child.required("value")?.to_owned());
                    self.names.entry(name).or_insert(value);
                }
                "path" => {
                    let name = child.required("value")?;
                    let folder = child.at.folder().join(name);
                    let missing = || child.error_at("value", format!("there is no folder {}", folder.display()));
                    require(folder.is_dir(), missing)?;
                    self.folders.insert(0, folder);
                }
                "include" => self.include(&child, &mut node, depth, old)?,
                _ => node.children.push(child),
            }
        }
        Ok(node)
    }

    fn include(&mut self, include: &Node, into: &mut Node, depth: usize, old: bool) -> Result<()> {
        let name = include.required("filename")?;
        let path = resolve(name, include, &self.folders);
        let wrong = |message: String| include.error_at("filename", message);
        self.includes.open(&path).map_err(wrong)?;
        self.made.files.push(path.clone());
        let unread = |message: String| wrong(format!("{}: {message}", path.display()));
        let root = self.load(&path, depth + 1, old).map_err(|error| files::where_included(error, unread))?;
        self.includes.close();
        match root.tag.as_str() {
            "scene" => into.children.extend(root.children),
            _ => into.children.push(root),
        }
        Ok(())
    }

    /// The lines of a .spd file as pairs.
    fn spectrum(&mut self, node: &Node) -> Result<String> {
        let name = node.required("filename")?;
        let path = resolve(name, node, &self.folders);
        self.made.assets.stamp_files(&path);
        let broken = |reason: String| node.error_at("filename", format!("{}: {reason}", path.display()));
        let pairs = spectrum::pairs_of_file(&path).map_err(broken)?;
        self.made.files.push(path.clone());
        Ok(pairs.iter().map(|(wavelength, value)| format!("{wavelength}:{value}")).collect::<Vec<_>>().join(" "))
    }

    /// A value whose names are replaced.
    fn replaced(&mut self, value: &str) -> std::result::Result<String, String> {
        let mut out = String::new();
        let mut rest = value;
        while let Some((before, after)) = rest.split_once('$') {
            out.push_str(before);
            let wrong = || format!("expected values of names of at most {LONGEST_VALUE} bytes");
            require(out.len() <= LONGEST_VALUE, wrong)?;
            let known = self.names.iter().filter(|(name, _)| after.starts_with(name.as_str()));
            let Some((name, value)) = known.max_by_key(|(name, _)| name.len()) else {
                let end = after.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(after.len());
                let name = after.get(..end).unwrap_or(after);
                return Err(format!(
                    "${name} has no value: give one by -D {name}=VALUE or <default name=\"{name}\" ..>"
                ));
            };
            out.push_str(value);
            rest = after.get(name.len()..).unwrap_or("");
            self.used.insert(name.clone());
        }
        out.push_str(rest);
        Ok(out)
    }
}

/// The path of a file that an element names: in the folders that `path` gives, the last one first, and that of the scene; else beside its own
/// file. An include is searched for there first.
pub fn resolve(name: &str, node: &Node, folders: &[PathBuf]) -> PathBuf {
    let beside = node.at.folder().join(name);
    let first = Some(beside.clone()).filter(|_| node.tag == "include");
    let others = folders.iter().map(|folder| folder.join(name));
    first.into_iter().chain(others).find(|path| path.exists()).unwrap_or(beside)
}

/// What is told of a path that may lead out of the folder of its file.
fn outside(name: &str, node: &Node) -> Option<String> {
    let leads_out = Path::new(name).components().any(|part| !matches!(part, Component::Normal(_) | Component::CurDir));
    leads_out.then(|| node.error(format!("it is outside of the scene's folder: {name}")).to_string())
}

/// `toWorld` as `to_world`, and `intIOR` as `int_ior`.
fn snake_case(name: &str) -> String {
    let mut out = String::new();
    let mut before = 'A';
    for c in name.chars() {
        if c.is_uppercase() && !before.is_uppercase() {
            out.push('_');
        }
        out.extend(c.to_lowercase());
        before = c;
    }
    out
}

struct Text<'a> {
    path: Arc<Path>,
    text: &'a str,
    /// The latest offset, its line and its column: most that are asked for are behind it.
    last: Cell<(usize, u32, u32)>,
}

impl Text<'_> {
    fn place(&self, offset: usize) -> Place {
        let last = Some(self.last.get()).filter(|(known, ..)| *known <= offset);
        let (known, mut line, mut column) = last.unwrap_or((0, 1, 1));
        for c in self.text.get(known..offset).unwrap_or("").chars() {
            (line, column) = if c == '\n' { (line + 1, 1) } else { (line, column + 1) };
        }
        self.last.set((offset, line, column));
        Place { file: Arc::clone(&self.path), line, column }
    }
}

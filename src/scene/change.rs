//! Changes of a scene by a request: another camera, objects placed elsewhere, other values of materials and lights.

use std::collections::BTreeMap;
use std::path::Path;

use glam::{DAffine3, DMat3, DVec3};

use super::explain::explain;
use super::findings::Findings;
use super::gltf::similarity;
use super::model::Scene;
use super::nearest::{meant, one_of};
use super::recover::Parts;
use super::syntax::options;
use super::types::{Camera, Material, Object, Texture, Transform};
use super::validate;
use super::write::value;
use crate::error::{Error, Location, Result};
use crate::source::{Source, ValuePath, slice};

/// A change of a scene. Its texts have the notation of scene files.
#[derive(Clone, Debug, Default)]
pub struct Change<'a> {
    /// Fields of the camera, such as `(look_from: (0, 1, 5), look_at: (0, 0, 0))`. The others stay, but for those that these take the place
    /// of: `moving`, and the other one of `vertical_fov` and `projection`.
    pub camera: Option<&'a str>,
    /// By the names of objects, or their places `objects[3]`: the rows of a matrix that is applied after the object's own transforms.
    pub objects: Option<&'a BTreeMap<String, Rows>>,
    /// By the names of materials and of lights without size: fields, such as `(fuzz: 0.2)`, or all of a material. Images are those that the
    /// scene has.
    pub materials: Option<&'a BTreeMap<String, String>>,
}

/// The rows of a matrix.
pub type Rows = [[f64; 4]; 4];

/// The name of a request in errors.
const REQUEST: &str = "<request>";

impl Scene {
    /// The scene with a change.
    ///
    /// # Errors
    /// `Error::Scene`, or several of them, if the change names what is not there, is not in the notation of scene files, or makes the scene
    /// invalid.
    pub fn changed(&self, change: &Change<'_>) -> Result<Scene> {
        let mut scene = self.clone();
        if let Some(fields) = change.camera {
            scene.camera = self.camera_with(fields).map_err(of_request)?;
        }
        for (name, rows) in change.objects.into_iter().flatten() {
            scene.place(name, rows)?;
        }
        for (name, fields) in change.materials.into_iter().flatten() {
            scene.change_material(name, fields).map_err(of_request)?;
        }
        if change.objects.is_some() || change.materials.is_some() {
            let mut findings = Findings::default();
            validate::objects(&scene, &mut findings);
            findings.end()?;
        }
        Ok(scene)
    }

    /// The names of the objects that a change can name.
    pub fn object_names(&self) -> Vec<&str> {
        let mut names = Vec::new();
        self.visit_objects(&mut |_, object| {
            if let Object::Named { name, .. } = object
                && !names.contains(&name.as_str())
            {
                names.push(name.as_str());
            }
        });
        names
    }

    fn camera_with(&self, fields: &str) -> Result<Camera> {
        let gone = |name: &str, given: &dyn Fn(&str) -> bool| match name {
            "vertical_fov" => given("projection"),
            "projection" => given("vertical_fov"),
            "moving" => given("look_from") || given("look_at"),
            _ => false,
        };
        let text =
            format!("Scene(camera: {})", merged("camera", &value(&self.camera).unwrap_or_default(), fields, gone)?);
        let (parts, source) = read(text)?;
        let mut findings = Findings::default();
        let camera = parts.camera.unwrap_or_else(|| self.camera.clone());
        validate::camera(&ValuePath::top(&source).field("camera"), &camera, &mut findings);
        findings.end().map(|()| camera)
    }

    /// Places the objects of a name by the rows of a matrix.
    fn place(&mut self, name: &str, rows: &Rows) -> Result<()> {
        let by = transforms(rows).map_err(|reason| error_of("objects", name, &reason))?;
        let put = |object: &mut Object| {
            let inner = std::mem::replace(object, Object::Group(Vec::new()));
            *object = Object::Transformed { by: by.clone(), object: Box::new(inner) };
        };
        let index = name.strip_prefix("objects[").and_then(|rest| rest.strip_suffix(']')?.parse::<usize>().ok());
        let found = match index.and_then(|index| self.objects.get_mut(index)) {
            Some(object) => {
                // The name stays outside.
                if let Object::Named { object, .. } = object {
                    put(object)
                } else {
                    put(object)
                };
                true
            }
            None => find(&mut self.objects, name, &mut |object| {
                put(object);
                true
            }),
        };
        if found {
            return Ok(());
        }
        let known = self.object_names();
        let names = || known.iter().copied();
        let known = one_of(names(), "the scene names none: Named(name: .., object: ..), or by its place, objects[0]");
        Err(error_of("objects", name, &format!("there is no object {name:?}: {known}{}", meant(name, names()))))
    }

    /// Gives a material, or the lights of a name, other values.
    fn change_material(&mut self, name: &str, fields: &str) -> Result<()> {
        let keep = |_: &str, _: &dyn Fn(&str) -> bool| false;
        if let Some((_, material)) = self.materials.iter_mut().find(|(known, _)| known == name) {
            let written = value(material).unwrap_or_default();
            let quoted = value(name).unwrap_or_default();
            let at = format!("materials[{name:?}]");
            let (parts, source) =
                read(format!("Scene(materials: {{{quoted}: {}}})", merged(&at, &written, fields, keep)?))?;
            let Some((_, new)) = parts.materials.into_iter().next() else { return Ok(()) };
            new.check(&ValuePath::top(&source).field("materials").key(name))?;
            *material = new;
            return self.check_images(name);
        }
        let mut failed = None;
        let mut change = |object: &mut Object| {
            let lit = object.delta_light().is_some();
            if lit {
                let written = value(object).unwrap_or_default();
                let read =
                    merged(name, &written, fields, keep).and_then(|text| read(format!("Scene(objects: [{text}])")));
                match read.map(|(parts, _)| parts.objects.unwrap_or_default().pop()) {
                    Ok(Some(new)) => *object = new,
                    Ok(None) => {}
                    Err(error) => failed = Some(error),
                }
            }
            lit
        };
        let found = find(&mut self.objects, name, &mut |object| lights(object, &mut change));
        match (failed, found) {
            (Some(error), _) => Err(error),
            (None, true) => Ok(()),
            (None, false) => {
                let names = || self.materials.iter().map(|(known, _)| known.as_str());
                let known = one_of(names(), "the scene has none");
                let message = format!("there is no material or light {name:?}: {known}{}", meant(name, names()));
                Err(error_of("materials", name, &message))
            }
        }
    }

    /// Refuses a material with an image that has not been read.
    fn check_images(&self, name: &str) -> Result<()> {
        let material = self.materials.iter().find(|(known, _)| known == name);
        let decoded =
            material.into_iter().flat_map(|(_, material)| Material::textures(material)).filter_map(Texture::decoded);
        match decoded.into_iter().find(|(path, decoding)| self.bitmaps.get(path, *decoding).is_none()) {
            Some((path, _)) => Err(error_of("materials", name, &format!("the scene has not read the image {path:?}"))),
            None => Ok(()),
        }
    }
}

/// The transforms of a matrix.
fn transforms(rows: &Rows) -> std::result::Result<Vec<Transform>, String> {
    let [x, y, z, last] = rows.map(glam::DVec4::from_array);
    let matrix = DMat3::from_cols(x.truncate(), y.truncate(), z.truncate()).transpose();
    let affine = DAffine3 { matrix3: matrix, translation: DVec3::new(x.w, y.w, z.w) };
    let found = similarity(&affine).filter(|_| last == glam::DVec4::W);
    let expected = "expected a matrix of a rotation, a shift and one positive scale, whose last row is 0, 0, 0, 1";
    found.ok_or_else(|| format!("{expected}, found {rows:?}"))
}

/// Calls `change` with what has this name, but not with what has it inside of that. True if any call returned that.
fn find(objects: &mut [Object], name: &str, change: &mut dyn FnMut(&mut Object) -> bool) -> bool {
    let mut found = false;
    for object in objects {
        found |= match object {
            Object::Named { name: own, object } if own == name => change(object),
            Object::Named { object, .. }
            | Object::Transformed { object, .. }
            | Object::Moving { object, .. }
            | Object::Medium { boundary: object, .. } => find(std::slice::from_mut(object), name, change),
            Object::Group(objects) | Object::Gltf { objects, .. } => find(objects, name, change),
            _ => false,
        };
    }
    found
}

/// Calls `change` with what is in no other object.
fn lights(object: &mut Object, change: &mut dyn FnMut(&mut Object) -> bool) -> bool {
    match object {
        Object::Named { object, .. } | Object::Transformed { object, .. } | Object::Moving { object, .. } => {
            lights(object, change)
        }
        Object::Group(objects) | Object::Gltf { objects, .. } => {
            objects.iter_mut().fold(false, |found, object| lights(object, change) | found)
        }
        _ => change(object),
    }
}

/// The text of a value with other fields. `gone` says which fields of the value have no place beside those that are given.
fn merged(at: &str, written: &str, fields: &str, gone: impl Fn(&str, &dyn Fn(&str) -> bool) -> bool) -> Result<String> {
    let new = Source::new(fields.to_owned(), Path::new(REQUEST));
    let wrong = || Error::Scene {
        location: Location { file: REQUEST.into(), line: 0, column: 0 },
        field: at.to_owned(),
        message: format!("expected fields in brackets, such as (name: value), found {fields}"),
    };
    let (spans, text) = (&new.spans, new.text());
    let is_broken = spans.mismatch.is_some() || spans.unclosed_bracket.is_some() || spans.unclosed_comment.is_some();
    let root = spans.root.filter(|_| !is_broken).ok_or_else(wrong)?;
    if !spans.name(text, root).is_empty() {
        return Ok(fields.to_owned());
    }
    let given = fields_of(&new);
    if given.len() != spans.children(root).len() || given.is_empty() && text.trim() != "()" {
        return Err(wrong());
    }
    let own = Source::new(written.to_owned(), Path::new(REQUEST));
    let is_given = |name: &str| given.iter().any(|(given, _)| *given == name);
    let kept = fields_of(&own).into_iter().filter(|(name, _)| !is_given(name) && !gone(name, &is_given));
    let name = own.spans.root.map_or("", |root| own.spans.name(own.text(), root));
    let form = Material::FORMS.iter().find(|form| form.name == name);
    let takes_texture =
        |field: &str| form.and_then(|form| form.field(field)).is_some_and(|field| field.takes.is_texture());
    // Three numbers are a plain colour.
    let given = given.iter().map(|(name, value)| match takes_texture(name) && value.starts_with('(') {
        true => format!("{name}: Rgb{value}"),
        false => format!("{name}: {value}"),
    });
    let all: Vec<String> = kept.map(|(name, value)| format!("{name}: {value}")).chain(given).collect();
    Ok(format!("{name}({})", all.join(", ")))
}

/// The fields of a value with their texts.
fn fields_of(source: &Source) -> Vec<(&str, &str)> {
    let (spans, text) = (&source.spans, source.text());
    let children = spans.root.map_or(&[][..], |root| spans.children(root));
    let field = |id| (slice(text, spans.key(id)), slice(text, spans.value(id)));
    children.iter().map(|id| field(*id)).filter(|(name, _)| !name.is_empty()).collect()
}

/// Reads parts of a scene.
fn read(text: String) -> Result<(Parts, Source)> {
    let source = Source::new(text, Path::new(REQUEST));
    match options().from_str::<Parts>(source.text()) {
        Ok(parts) => Ok((parts, source)),
        Err(error) => Err(explain(&source, error).error),
    }
}

fn error_of(section: &str, name: &str, message: &str) -> Error {
    let location = Location { file: REQUEST.into(), line: 0, column: 0 };
    Error::Scene { location, field: format!("{section}[{name:?}]"), message: message.to_owned() }
}

/// An error without a line and a column, which are those of a text that nobody has written.
fn of_request(error: Error) -> Error {
    match error {
        Error::Scene { field, message, .. } => {
            Error::Scene { location: Location { file: REQUEST.into(), line: 0, column: 0 }, field, message }
        }
        Error::Several { errors, more } => {
            Error::Several { errors: errors.into_iter().map(of_request).collect(), more }
        }
        other => other,
    }
}

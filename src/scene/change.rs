//! Changes of a scene by a request: another camera, objects placed elsewhere, other values of materials and lights.

use std::collections::{BTreeMap, HashSet};
use std::path::Path;

use glam::{DAffine3, DMat4, DVec4};

use super::explain::explain;
use super::findings::Findings;
use super::gltf::similarity;
use super::model::Scene;
use super::nearest::{meant, one_of};
use super::recover::Parts;
use super::syntax::options;
use super::types::{Camera, Material, Object, Texture};
use super::validate;
use super::write::value;
use crate::error::{Error, Location, Result};
use crate::source::{Source, ValuePath, slice};

/// A change of a scene. Its texts have the notation of scene files.
#[derive(Clone, Debug, Default)]
pub struct Change<'a> {
    /// Fields of the camera, such as `(look_from: (0, 1, 5))`. The others stay, but for those that these take the place of: `moving`, and the
    /// other one of `vertical_fov` and `projection`.
    pub camera: Option<&'a str>,
    /// By the names of objects, or their places `objects[3]`: a matrix that is applied after the object's own transforms.
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
            scene.camera = self.camera_with(fields).map_err(without_location)?;
        }
        for (name, rows) in change.objects.into_iter().flatten() {
            scene.place(name, rows)?;
        }
        for (name, fields) in change.materials.into_iter().flatten() {
            scene.change_material(name, fields).map_err(without_location)?;
        }
        if change.objects.is_some() || change.materials.is_some() {
            let mut findings = Findings::default();
            validate::objects(&scene, &mut findings);
            findings.end()?;
        }
        Ok(scene)
    }

    /// The names that objects have.
    pub fn object_names(&self) -> Vec<&str> {
        let (mut names, mut known) = (Vec::new(), HashSet::new());
        self.visit_objects(&mut |_, object| match object {
            Object::Named { name, .. } if known.insert(name) => names.push(name.as_str()),
            _ => {}
        });
        names
    }

    fn camera_with(&self, fields: &str) -> Result<Camera> {
        let is_replaced = |name: &str, given: &[&str]| match name {
            "vertical_fov" => given.contains(&"projection"),
            "projection" => given.contains(&"vertical_fov"),
            "moving" => given.contains(&"look_from") || given.contains(&"look_at"),
            _ => false,
        };
        let text = merged("camera", &value(&self.camera).unwrap_or_default(), fields, is_replaced)?;
        let (parts, source) = read(format!("Scene(camera: {text})"))?;
        let (camera, mut findings) = (parts.camera.unwrap_or_else(|| self.camera.clone()), Findings::default());
        validate::camera(&ValuePath::top(&source).field("camera"), &camera, &mut findings);
        findings.end().map(|()| camera)
    }

    /// Places the objects of a name by a matrix.
    fn place(&mut self, name: &str, rows: &Rows) -> Result<()> {
        let at = format!("objects[{name:?}]");
        let matrix = DMat4::from_cols_array_2d(rows).transpose();
        let by = similarity(&DAffine3::from_mat4(matrix)).filter(|_| matrix.row(3) == DVec4::W).ok_or_else(|| {
            let expected =
                "expected a matrix of a rotation, a shift and one positive scale, whose last row is 0, 0, 0, 1";
            wrong(&at, &format!("{expected}, found {rows:?}"))
        })?;
        let place = name.strip_prefix("objects[").and_then(|rest| rest.strip_suffix(']')?.parse::<usize>().ok());
        let mut found = match place.and_then(|place| self.objects.get_mut(place)) {
            Some(object) => vec![object],
            None => named(&mut self.objects, name),
        };
        for object in &mut found {
            let inner = Box::new(std::mem::replace(*object, Object::Group(Vec::new())));
            **object = Object::Transformed { by: by.clone(), object: inner };
        }
        (!found.is_empty()).then_some(()).ok_or_else(|| unknown(&at, "object", name, &self.object_names()))
    }

    /// Gives a material, or the lights of a name, other values.
    fn change_material(&mut self, name: &str, fields: &str) -> Result<()> {
        let at = format!("materials[{name:?}]");
        if let Some((_, material)) = self.materials.iter_mut().find(|(known, _)| known == name) {
            let text = merged(&at, &value(material).unwrap_or_default(), fields, |_, _| false)?;
            let (parts, source) = read(format!("Scene(materials: {{{}: {text}}})", value(name).unwrap_or_default()))?;
            let Some((_, new)) = parts.materials.into_iter().next() else { return Ok(()) };
            new.check(&ValuePath::top(&source).field("materials").key(name))?;
            let mut images = new.textures().into_iter().filter_map(Texture::decoded);
            if let Some((path, _)) = images.find(|(path, decoding)| self.bitmaps.get(path, *decoding).is_none()) {
                return Err(wrong(&at, &format!("the scene has not read the image {path:?}")));
            }
            *material = new;
            return Ok(());
        }
        let lights: Vec<&mut Object> = named(&mut self.objects, name).into_iter().flat_map(lights).collect();
        if lights.is_empty() {
            let names: Vec<&str> = self.materials.iter().map(|(known, _)| known.as_str()).collect();
            return Err(unknown(&at, "material or light", name, &names));
        }
        for light in lights {
            let text = merged(&at, &value(light).unwrap_or_default(), fields, |_, _| false)?;
            let (parts, _) = read(format!("Scene(objects: [{text}])"))?;
            parts.objects.into_iter().flatten().for_each(|new| *light = new);
        }
        Ok(())
    }
}

/// The objects of this name, but not those inside of others of it.
fn named<'a>(objects: impl IntoIterator<Item = &'a mut Object>, name: &str) -> Vec<&'a mut Object> {
    let inside = |object: &'a mut Object| {
        let is_it = matches!(object, Object::Named { name: own, .. } if own == name);
        if is_it { children(object) } else { named(children(object), name) }
    };
    objects.into_iter().flat_map(inside).collect()
}

/// The lights without size of an object.
fn lights(object: &mut Object) -> Vec<&mut Object> {
    match object.delta_light() {
        Some(_) => vec![object],
        None => children(object).into_iter().flat_map(lights).collect(),
    }
}

/// The objects that an object has.
fn children(object: &mut Object) -> Vec<&mut Object> {
    match object {
        Object::Named { object, .. }
        | Object::Transformed { object, .. }
        | Object::Moving { object, .. }
        | Object::Medium { boundary: Some(object), .. } => vec![object],
        Object::Group(objects) | Object::Gltf { objects, .. } => objects.iter_mut().collect(),
        _ => Vec::new(),
    }
}

/// The text of a value with other fields. `is_replaced` says which fields have no place beside those that are given.
fn merged(at: &str, written: &str, fields: &str, is_replaced: impl Fn(&str, &[&str]) -> bool) -> Result<String> {
    let source = |text: &str| Source::new(text.to_owned(), Path::new(REQUEST));
    let (own, new) = (source(written), source(fields));
    let is_broken =
        new.spans.mismatch.is_some() || new.spans.unclosed_bracket.is_some() || new.spans.unclosed_comment.is_some();
    let Some(root) = new.spans.root.filter(|_| !is_broken && fields.trim_end().ends_with(')')) else {
        return Err(wrong(at, &format!("expected fields in brackets, such as (name: value), found {fields}")));
    };
    if !new.spans.name(fields, root).is_empty() {
        return Ok(fields.to_owned());
    }
    let name = own.spans.root.map_or("", |root| own.spans.name(written, root));
    let form = Material::FORMS.iter().find(|form| form.name == name);
    let is_texture =
        |field: &str| form.and_then(|form| form.field(field)).is_some_and(|field| field.takes.is_texture());
    // Three numbers are a plain colour.
    let colour = |field: &str, text: &str| if is_texture(field) && text.starts_with('(') { "Rgb" } else { "" };
    let given = fields_of(&new);
    let names: Vec<&str> = given.iter().map(|(name, _)| *name).collect();
    let kept = fields_of(&own).into_iter().filter(|(name, _)| !names.contains(name) && !is_replaced(name, &names));
    let field = |(name, text): (&str, &str)| format!("{name}: {}{text}", colour(name, text));
    let all: Vec<String> = kept.chain(given.iter().copied()).map(field).collect();
    Ok(format!("{name}({})", all.join(", ")))
}

/// The fields of a value with their texts.
fn fields_of(source: &Source) -> Vec<(&str, &str)> {
    let (spans, text) = (&source.spans, source.text());
    let children = spans.root.map_or(&[][..], |root| spans.children(root));
    children.iter().map(|id| (slice(text, spans.key(*id)), slice(text, spans.value(*id)))).collect()
}

/// Reads parts of a scene.
fn read(text: String) -> Result<(Parts, Source)> {
    let source = Source::new(text, Path::new(REQUEST));
    match options().from_str::<Parts>(source.text()) {
        Ok(parts) => Ok((parts, source)),
        Err(error) => Err(explain(&source, error).error),
    }
}

fn unknown(at: &str, what: &str, name: &str, names: &[&str]) -> Error {
    let names = || names.iter().copied();
    wrong(
        at,
        &format!("there is no {what} {name:?}: {}{}", one_of(names(), "the scene names none"), meant(name, names())),
    )
}

fn wrong(at: &str, message: &str) -> Error {
    let location = Location { file: REQUEST.into(), line: 0, column: 0 };
    Error::Scene { location, field: at.to_owned(), message: message.to_owned() }
}

/// An error without a line and a column, which are those of a text that nobody has written.
fn without_location(error: Error) -> Error {
    match error {
        Error::Scene { field, message, .. } => wrong(&field, &message),
        Error::Several { errors, more } => {
            Error::Several { errors: errors.into_iter().map(without_location).collect(), more }
        }
        other => other,
    }
}

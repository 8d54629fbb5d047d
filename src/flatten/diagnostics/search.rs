//! The input and the results of the search for warnings.

use glam::DVec3;

use crate::flatten::finder::{Finder, Primitive};
use crate::flatten::view::View;
use crate::material::Emitted;
use crate::printable::and_more;
use crate::scene::{Material, Object, Scene};
use crate::shape::similarity::Similarity;
use crate::shape::{BoundingShape, ObjectTransform, RenderSpace, Shape};

/// Half a unit in the last place (ulp) of 1 in f32: the largest relative error of a rounding.
pub const U: f64 = 1.0 / (1u64 << 24) as f64;

/// The scene in which the warnings are searched for, with the transforms of its objects.
pub struct Search<'a> {
    pub scene: &'a Scene,
    pub finder: &'a Finder<'a>,
    pub view: &'a View<'a>,
    /// The largest distance from the camera along an axis, of any point of an object.
    pub extent: f64,
    /// Whether the background or an object emits light.
    pub is_lit: bool,
    /// By the number of the material.
    pub roles: Vec<Role>,
}

impl<'a> Search<'a> {
    pub fn new(
        scene: &'a Scene,
        finder: &'a Finder<'a>,
        view: &'a View<'a>,
        extent: f64,
        is_lit: bool,
        emissions: &[Emitted],
    ) -> Search<'a> {
        let role = |(((_, material), emitted), needed): ((&(String, Material), &Emitted), &Vec<usize>)| {
            let model = material.model();
            let transmissive = needed.iter().any(|number| scene.materials[*number].1.is_transmissive());
            Role {
                transmissive,
                opaque: !transmissive && !model.has_alpha(),
                light: emitted.is_seen(),
                one_sided: model.emission().is_some_and(|emission| !emission.two_sided),
            }
        };
        let roles = scene.materials.iter().zip(emissions).zip(&finder.needed).map(role).collect();
        Search { scene, finder, view, extent, is_lit, roles }
    }

    pub fn body(&self, number: usize) -> Body<'a> {
        let Primitive { object, shape, to_world, material, .. } = &self.finder.primitives[number];
        let role = self.roles[*material as usize];
        Body { material: *material, role, ..self.new_body(object, shape, to_world) }
    }

    /// The objects that rest: where one that moves is at one time says little.
    pub fn bodies(&self) -> impl Iterator<Item = Body<'a>> {
        let primitives = self.finder.primitives.iter().enumerate();
        primitives.filter(|(_, found)| found.motion.is_empty()).map(|(number, _)| self.body(number))
    }

    /// The boundaries of the media, which have no material, and which light passes.
    pub fn boundaries(&self) -> impl Iterator<Item = Body<'a>> {
        let media = self.finder.media.iter();
        media.map(|medium| self.new_body(medium.object, &medium.boundary, &medium.to_world))
    }

    pub fn new_body(&self, object: &'a Object, shape: &'a Shape<'a>, to_world: &'a Similarity) -> Body<'a> {
        let bounds =
            shape.bounding_shape(&ObjectTransform { to_world, space: RenderSpace { eye: self.view.eye, scale: 1.0 } });
        let role = Role { transmissive: true, opaque: false, light: false, one_sided: false };
        Body { object, shape, to_world, material: 0, role, bounds, position: bounds.position() }
    }
}

/// An object with its transform.
#[derive(Clone, Copy)]
pub struct Body<'a> {
    pub object: &'a Object,
    pub shape: &'a Shape<'a>,
    pub to_world: &'a Similarity,
    pub material: u32,
    pub role: Role,
    pub bounds: BoundingShape,
    /// The centre of a sphere, box or mesh; the corner of a quad.
    pub position: DVec3,
}

impl Body<'_> {
    pub fn word(&self) -> &'static str {
        self.shape.kind().word
    }
}

/// The properties of a material that matter here.
#[derive(Clone, Copy)]
pub struct Role {
    /// Rays pass through the object.
    pub transmissive: bool,
    /// No ray passes, not by an alpha either.
    pub opaque: bool,
    pub light: bool,
    pub one_sided: bool,
}

/// A warning whose locations in the file are not yet filled in.
pub struct Diagnostic<'a> {
    pub object: &'a Object,
    /// A field of the object, or "" for the object itself.
    pub field: &'static str,
    pub message: String,
    /// The object whose location replaces `OTHER` in the message.
    pub other: Option<&'a Object>,
}

impl<'a> Diagnostic<'a> {
    /// A warning about an object.
    pub fn of(object: &'a Object, message: impl Into<String>) -> Diagnostic<'a> {
        Diagnostic { object, field: "", message: message.into(), other: None }
    }
}

/// A placeholder in messages for the location of the other object.
pub const OTHER: &str = "{other}";

/// The number of cases of one kind, and the worst of them; the first of equally bad ones.
#[derive(Default)]
pub struct Worst<'a> {
    pub count: usize,
    pub worst: Option<(f64, Diagnostic<'a>)>,
}

impl<'a> Worst<'a> {
    pub fn add(&mut self, badness: f64, warning: impl FnOnce() -> Diagnostic<'a>) {
        self.count += 1;
        self.offer(badness, warning);
    }

    /// Keeps the worst of cases that are counted already.
    pub fn offer(&mut self, badness: f64, warning: impl FnOnce() -> Diagnostic<'a>) {
        if self.worst.as_ref().is_none_or(|(worst, _)| badness > *worst) {
            self.worst = Some((badness, warning()));
        }
    }

    /// The warning about the worst case.
    pub fn text(self, scene: &Scene) -> Option<String> {
        let (_, Diagnostic { object, field, message, other }) = self.worst?;
        let other = other.map_or(String::new(), |other| scene.location_of(other).to_string());
        let message = message.replace(OTHER, &other) + &and_more(self.count - 1);
        let mut text = None;
        scene.visit_objects(&mut |at, visited| {
            if std::ptr::eq(visited, object) {
                text = Some(if field.is_empty() { at.warning(&message) } else { at.field(field).warning(&message) });
            }
        });
        text
    }
}

/// The warning about two surfaces, the first of them the one that the file has first, that are less than `bound` apart.
pub fn coincidence<'a>(first: &Body<'a>, second: &Body<'a>, gap: f64, bound: f64) -> Diagnostic<'a> {
    // If only one of them is transmissive, the warning is about that one.
    let (at, other) =
        if first.role.transmissive && !second.role.transmissive { (first, second) } else { (second, first) };
    let limit = short(bound);
    // Smaller gaps come from the rounding of transforms in f64.
    let apart = match gap <= 1e-3 * bound {
        true => "coincides with it".to_string(),
        false => format!("is {} away, less than f32 resolves there ({limit})", short(gap)),
    };
    let (what, consequence, remedy) = match at.role.transmissive {
        true => (
            "this glass",
            "rays that leave one of the two start behind the other and miss it",
            "or let an opaque one reach into the glass",
        ),
        false => ("it", "rounding, or their order in the file, decides which of the two is visible", "or remove one"),
    };
    let message = format!(
        "{what} touches the {} at {OTHER}, which {apart}: {consequence}: set them more than {limit} apart, {remedy}",
        other.word()
    );
    Diagnostic { other: Some(other.object), ..Diagnostic::of(at.object, message) }
}

/// A number rounded to four digits.
pub fn short(x: f64) -> String {
    let rounded: f64 = format!("{x:.3e}").parse().unwrap_or(x);
    match rounded.abs() {
        0.0 => "0".to_string(),
        1e-3..1e6 => format!("{rounded}"),
        _ => format!("{rounded:e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::short;

    #[test]
    fn numbers_are_short() {
        let cases = [(0.0, "0"), (1e-7, "1e-7"), (0.125, "0.125"), (123456.0, "123500"), (2e7, "2e7"), (-0.5, "-0.5")];
        for (x, text) in cases {
            assert_eq!(short(x), text);
        }
    }
}

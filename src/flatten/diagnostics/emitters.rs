//! Finds emitters that no path can reach, and emitters that are too faint beside others.
//!
//! It finds four cases of unreachable light: a background beyond a closed opaque object around the camera; a one-sided light with nothing on its emitting side; a closed light
//! around the camera that emits outwards; and a closed opaque sphere, box or mesh around either the light or the
//! camera, with the other one outside.

use glam::DVec3;

use super::within::{Within, is_outside_in_front};
use super::{At, Body, Diagnostic, Found, OTHER, Role, U, Worst, power_of_two, short};
use crate::flatten::place::Placed;
use crate::scene::Background;
use crate::shape::{Hull, normal};

/// The number of emitters that the search looks at.
const MOST_EMITTERS: usize = 4096;
/// The limit on comparisons, for each object.
const TESTS_EACH: usize = 1;
/// The number of objects around the camera that the search looks at.
const MOST_AROUND: usize = 8;
/// The largest allowed ratio of the brightest emitter's radiance to another's.
const LARGEST_SHARE: f64 = (1u64 << 60) as f64;

/// Finds one-sided quads with the whole scene and the camera behind them.
pub fn turned_away(found: &Found, kinds: &[Role]) -> Option<Diagnostic> {
    let shines = |kind: Role| kind.light && kind.one_sided;
    if !kinds.iter().any(|kind| shines(*kind)) {
        return None;
    }
    let body = |number: usize| Body::new(found, &found.placed[number].shape, &found.placed[number].to_world);
    let one_sided = |number: &usize| {
        let body = body(*number);
        let kind = kinds[found.placed[*number].material as usize];
        shines(kind) && body.shape.is_hull() && matches!(body.hull, Hull::Parallelogram { .. })
    };
    let mut lights = (0..found.placed.len()).filter(one_sided).peekable();
    lights.peek()?;
    let lens = DVec3::splat(found.view.lens_radius());
    let primitives = (0..found.placed.len()).map(body);
    let media = found.media.iter().map(|medium| Body::new(found, &medium.boundary, &medium.to_world));
    let nothing = (-lens, lens, lens);
    let (low, high, rounded) = primitives.chain(media).fold(nothing, |(low, high, rounded), body| {
        let (l, h) = body.hull.bounds();
        // The rounding of a large sphere is not that of its far side.
        let coordinates = if body.shape.large_sphere().is_some() { DVec3::ZERO } else { l.abs().max(h.abs()) };
        (low.min(l), high.max(h), rounded.max(coordinates))
    });
    let mut worst = Worst::default();
    for number in lights {
        let Hull::Parallelogram { corner, u, v } = body(number).hull else { continue };
        let n = normal(u, v);
        let farthest = DVec3::select(n.cmpge(DVec3::ZERO), high, low);
        let rounding = 8.0 * U * n.abs().dot(rounded);
        if n.dot(farthest - corner) <= rounding {
            worst.note(-(number as f64), At::Primitive(number));
        }
    }
    let message = "this light emits to one side, and the whole scene is on its other side: exchange u and v to turn it round, or make \
                   it two_sided";
    worst.diagnostic(|at| Diagnostic::of(at, "", message.to_string()))
}

/// An emitter, and a ball around it.
#[derive(Clone, Copy)]
struct EmittingBody {
    at: At,
    center: DVec3,
    radius: f64,
}

/// Finds closed opaque objects with an emitter inside and the camera outside, or the reverse.
pub struct Walls<'a> {
    found: &'a Found<'a>,
    /// Sorted by the x of their centres.
    emitters: Vec<EmittingBody>,
    /// The smallest radius of a ball around an emitter.
    smallest: f64,
    /// The number of comparisons that are left.
    tests: usize,
    /// The number of objects around the camera so far.
    around: usize,
    /// The emitter, the closed object, and whether the camera is the one inside.
    worst: Worst<(At, usize, bool)>,
    /// Closed lights around the camera that emit outwards.
    outwards: Worst<usize>,
    /// Whether all light comes from outside the scene: from the background and directional lights.
    only_background: bool,
    /// Closed opaque objects around the camera, where all light comes from outside the scene.
    rooms: Worst<usize>,
    within: Within,
}

impl<'a> Walls<'a> {
    pub fn new(found: &'a Found<'a>, kinds: &[Role]) -> Walls<'a> {
        let mut emitters: Vec<EmittingBody> = Vec::new();
        if kinds.iter().any(|kind| kind.light) {
            let lights = (0..found.placed.len()).filter(|number| kinds[found.placed[*number].material as usize].light);
            emitters.extend(lights.take(MOST_EMITTERS).map(|number| {
                let Placed { shape, to_world, .. } = &found.placed[number];
                let (center, radius) = Body::new(found, shape, to_world).hull.ball();
                EmittingBody { at: At::Primitive(number), center, radius }
            }));
        }
        let without_size = found.lights.iter().enumerate().take(MOST_EMITTERS).filter_map(|(number, (_, light))| {
            let center = light.place? - found.view.eye;
            Some(EmittingBody { at: At::Light(number), center, radius: 0.0 })
        });
        emitters.extend(without_size);
        emitters.sort_unstable_by(|a, b| a.center.x.total_cmp(&b.center.x));
        let is_outside = |at: At| match at {
            At::Light(number) => found.lights[number].1.place.is_none(),
            at => at == At::Background,
        };
        let background = found.emissions.iter().any(|(at, radiance)| is_outside(*at) && *radiance > 0.0);
        Walls {
            found,
            only_background: emitters.is_empty() && background,
            rooms: Worst::default(),
            smallest: emitters.iter().map(|emitter| emitter.radius).fold(f64::INFINITY, f64::min),
            emitters,
            tests: TESTS_EACH * (found.placed.len() + 1000),
            around: 0,
            worst: Worst::default(),
            outwards: Worst::default(),
            within: Within::default(),
        }
    }

    pub fn see(&mut self, number: usize, wall: &Body, kind: Role) {
        if (self.emitters.is_empty() && !self.only_background) || self.tests == 0 || kind.glass {
            return;
        }
        let lens = self.found.view.lens_radius();
        let Some(depth) = self.within.depth(wall, DVec3::ZERO) else { return };
        if depth > lens && self.around < MOST_AROUND {
            self.around += 1;
            if self.only_background {
                self.rooms.note(-(number as f64), number);
            }
            if kind.light && kind.one_sided && is_outside_in_front(wall) {
                self.outwards.note(-(number as f64), number);
            }
            for at in 0..self.emitters.len() {
                let emitter = self.emitters[at];
                let mut outside =
                    || self.within.depth(wall, emitter.center).is_some_and(|depth| -depth > emitter.radius);
                if emitter.at != At::Primitive(number) && outside() {
                    self.note(number, &emitter, true);
                }
            }
        } else if depth < -lens {
            let (_, reach) = wall.hull.ball();
            if reach <= self.smallest {
                return;
            }
            let from = self.emitters.partition_point(|emitter| emitter.center.x < wall.place.x - reach);
            for at in from..self.emitters.len() {
                let emitter = self.emitters[at];
                if emitter.center.x > wall.place.x + reach || self.tests == 0 {
                    break;
                }
                self.tests -= 1;
                let apart = (emitter.center - wall.place).abs();
                let near = apart.y < reach && apart.z < reach && emitter.radius < reach;
                if near
                    && emitter.at != At::Primitive(number)
                    && is_within(self.found, &mut self.within, wall, &emitter)
                {
                    self.note(number, &emitter, false);
                }
            }
        }
    }

    fn note(&mut self, wall: usize, emitter: &EmittingBody, around_camera: bool) {
        // The first of the file's objects, and lights without size behind the others.
        let number = match emitter.at {
            At::Light(number) => self.found.placed.len() + number,
            At::Primitive(number) | At::Medium(number) | At::Emit(number) => number,
            At::Background => 0,
        };
        self.worst.note(-(number as f64), (emitter.at, wall, around_camera));
    }

    pub fn diagnostics(self) -> Vec<Diagnostic> {
        let found = self.found;
        let outwards = self.outwards.diagnostic(|number| {
            let message = format!(
                "this light emits outwards, and the camera is in this {}: the camera sees none of its light, and its inside is black: \
                 make it two_sided",
                found.placed[number].shape.kind().word
            );
            Diagnostic::of(At::Primitive(number), "", message)
        });
        let hidden = self.worst.diagnostic(|(emitter, wall, around_camera)| {
            let shape = found.placed[wall].shape.kind().word;
            let (enclosed, beyond) = if around_camera { ("the camera", "light") } else { ("it", "camera") };
            let message = format!(
                "no path reaches this light: the opaque {shape} at {OTHER} encloses {enclosed}, and the {beyond} is outside: remove \
                 the light, or open the {shape}"
            );
            Diagnostic { other: Some(At::Primitive(wall)), ..Diagnostic::of(emitter, "", message) }
        });
        let rooms = self.rooms.diagnostic(|number| {
            let word = found.placed[number].shape.kind().word;
            let message = format!(
                "the camera is inside this opaque {word}, and no light is: the image is black. Move the camera out of it, open it, or put \
                 a light inside"
            );
            Diagnostic::of(At::Primitive(number), "", message)
        });
        [outwards, hidden, rooms].into_iter().flatten().collect()
    }
}

/// Whether an emitter is entirely within a sphere, box or mesh.
fn is_within(found: &Found, within: &mut Within, wall: &Body, emitter: &EmittingBody) -> bool {
    let At::Primitive(number) = emitter.at else {
        return within.depth(wall, emitter.center).is_some_and(|depth| depth > 0.0);
    };
    let Placed { shape, to_world, .. } = &found.placed[number];
    // A convex wall contains a flat emitter or a box if it contains the corners.
    let body = Body::new(found, shape, to_world);
    let by_ball = matches!(body.hull, Hull::Ball { .. }) || wall.shape.mesh().is_some();
    let least = if by_ball { emitter.radius } else { 0.0 };
    let mut inside = |p: DVec3, least: f64| within.depth(wall, p).is_some_and(|depth| depth > least);
    inside(emitter.center, least) && (by_ball || body.hull.corners().into_iter().all(|p| inside(p, 0.0)))
}

/// Finds emitters, or parts of them, that are so much fainter than the brightest that the film keeps few digits of them.
pub fn too_faint(found: &Found) -> Option<Diagnostic> {
    let (brightest, most) = found.emissions.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let limit = most / LARGEST_SHARE;
    let is_faint = |radiance: f64| radiance > 0.0 && radiance < limit;
    let mut worst = Worst::default();
    for &(at, radiance) in found.emissions {
        let part = if is_faint(radiance) { Some(radiance) } else { faint_part(found, at, is_faint) };
        if let Some(part) = part {
            worst.note(most / part, (at, part, radiance > part));
        }
    }
    worst.diagnostic(|(at_it, radiance, is_part)| {
        let message = format!(
            "a radiance of {}{} is {} of the radiance at {OTHER} ({}): the film has one unit for the whole image and keeps few digits \
             of radiances below {} of the brightest: render lights that differ so much in separate scenes",
            short(radiance),
            if is_part { " in a part of it" } else { "" },
            power_of_two(radiance / most),
            short(most),
            power_of_two(1.0 / LARGEST_SHARE)
        );
        Diagnostic { other: Some(brightest), ..Diagnostic::of(at_it, "", message) }
    })
}

/// The radiance of a part of an emitter that is too faint: the fainter colour of a checker, or the brightest of an
/// image's too faint texels, if they are many.
fn faint_part(found: &Found, at: At, is_faint: impl Fn(f64) -> bool) -> Option<f64> {
    let bitmaps = &found.scene.bitmaps;
    match at {
        At::Emit(number) => {
            found.scene.materials[number].1.model().emission()?.slot.texture.faint_part(bitmaps, is_faint)
        }
        At::Background => match &found.scene.background {
            Background::Image { path } => bitmaps.colours(path)?.faint_part(DVec3::ONE, is_faint),
            Background::Solid(_) | Background::Gradient { .. } => None,
        },
        At::Primitive(_) | At::Medium(_) | At::Light(_) => None,
    }
}

//! The facts of a kernel, which the heads of the shaders' modules name.
//!
//! A fact of materials, such as `alpha`, holds if a material has it that the kernel serves; `scene.alpha`, if any of the scene has it. A fact with a
//! dot, such as `moves.quad`, is one of a group; the group's name alone holds if one of the group does. Each has the reason of the first that holds.

use std::sync::LazyLock;

use crate::aov::{Aov, Finder, SeenSurface};
use crate::flatten::{BACKGROUNDS, DECLARED, Declared, EVERY_FEATURE, Features, MATERIALS, Quantities};
use crate::gpu::link::{Entry, Facts, Reason, When};
use crate::lobe::evaluated_rows;
use crate::material::{Material, MaterialKind, ROUGH_LAYER};
use crate::options::{self, RenderOptions, TRADE_OFFS, Walk};
use crate::shape::KINDS;

/// The facts that follow from others, by the conditions for them. Each names those before it.
const DERIVED: &[(&str, &str)] = &[
    // There is something to hit.
    ("surface", "scene.material"),
    // There are meshes, which have walks of their own.
    ("mesh", "shape.triangle"),
    // There are media.
    ("medium", "(boundary | media) & media"),
    // There is a surface or a medium.
    ("event", "surface | medium"),
    // A light is sampled.
    ("light", "(area_light | sky_light | delta_light | lights) & lights"),
    // A light at infinity is sampled.
    ("light_at_infinity", "sky_light | directional_light"),
    // A light has a radiance that a path gets before its end.
    ("sampled_light", "light | scene.emission | medium_emission"),
    // The children of a node of a mesh stand beside each other.
    ("siblings", "walk.siblings & (mesh | boundary.mesh)"),
    // Every ray tests all primitives.
    ("brute_force", "(mesh | shape | few_primitives) & few_primitives & surface"),
    // Lobes hide light from light sampling; probes count it.
    ("probed", "(scene.narrow_lobe | narrow_medium | scene.specular_lobe) & light"),
    // A material sends rays to lights.
    ("sends_shadow_ray", "light & wide_lobe | (narrow_lobe | specular_lobe) & probed"),
    // A material has a number that is evaluated at the hit.
    ("evaluated", "extension | vertex_colours & mesh"),
    // A material has a boundary of glass that reflects.
    ("glass", "scene.transmissive | scene.transmission | scene.layered"),
    // A sphere is hit, or bounds a medium.
    ("ball", "shape.sphere | boundary.sphere"),
    // A surface lets a share of light pass.
    ("alpha", "scene.alpha & surface"),
    // A convex body lets a share of light pass.
    ("alpha_body", "body_with_alpha & alpha"),
    // Light passes a smooth surface straight on.
    ("pane", "smooth_pane & surface"),
    // A mesh has several tables of texture coordinates.
    ("further_uv", "uv_tables & mesh"),
    // Lights behind a surface that scatters light through itself are seen, too.
    ("both_sides", "(both_sided | transmission | diffuse_transmission) & light & smooth"),
    // A surface emits.
    ("emits", "shining | emission"),
    // Something moves.
    ("motion", "moves | boundary_moves | moving_camera | moving_light | moving_medium"),
    // Sums of `--aov`, by the stage that finds them.
    ("aov_hit", "(aov.hit | mattes) & surface"),
    ("aov_surface", "aov.surface & event"),
    ("aov_rough", "aov_surface & seen.rough"),
    // Radiance is stored until a sample ends.
    ("aov_until_end", "aov.direct | aov.lights"),
    // Light paths meet narrow lobes, or solids that absorb light.
    ("light_paths_of_narrow_lobes", "scene.narrow_lobe & light_paths"),
    ("light_paths_through_solids", "scene.absorbing & light_paths"),
];

/// The facts that follow from others, with their conditions, or what is wrong with these.
pub static CONDITIONS: LazyLock<Vec<(String, Result<When, String>)>> = LazyLock::new(|| {
    let extension = evaluated_rows().map(|row| row.name).collect::<Vec<_>>().join(" | ");
    // Convex bodies that a ray crosses: those that are panes, and those with an alpha.
    let bodies: Vec<&str> = KINDS.iter().filter(|kind| kind.encloses()).map(|kind| kind.shader).collect();
    let crossed = |shape: &&str| {
        let condition = format!("shape.{shape} & (smooth_pane.{shape} & pane | body_with_alpha.{shape} & alpha_body)");
        (format!("crossed_body.{shape}"), condition)
    };
    let derived = DERIVED.iter().map(|(name, when)| ((*name).to_string(), (*when).to_string()));
    let all = [("extension".to_string(), extension)].into_iter().chain(derived).chain(bodies.iter().map(crossed));
    let crossed_body = format!("crossed_body.{}", bodies.join(" | crossed_body."));
    // A hit, or a light, has the instance of a mesh, or the side of a body.
    let sides = [("instance", "mesh | crossed_body"), ("light_instance", "area_light.triangle | crossed_light")];
    let sides = sides.map(|(name, when)| (name.to_string(), when.to_string()));
    let all = all.chain([("crossed_body".to_string(), crossed_body)]).chain(sides);
    all.map(|(name, when)| (name, When::parse(&when))).collect()
});

/// The reason for kernels and modules that sort slots into queues.
pub(super) const QUEUES: &str = "--scatter queues";

/// How the stages of a bounce are split into kernels.
#[derive(Clone, Copy)]
pub(super) struct Bounces {
    pub fused: bool,
    pub queues: bool,
}

/// What a kernel is for.
#[derive(Clone, Copy)]
pub(super) struct Purpose<'a> {
    /// The materials that it serves.
    pub served: &'a [Entry],
    pub bounces: Bounces,
    /// Whether it traces light paths.
    pub light_path: bool,
}

/// All facts of a kernel.
pub(super) fn facts(features: &Features, options: &RenderOptions, purpose: Purpose<'_>) -> Facts {
    let mut facts = Facts::new();
    let reason = |fact: &str| features.reason(fact).cloned().map(Reason::Requested);
    // Any kernel may meet a kind that has no functions: a mix.
    let is_served = |number: usize| {
        !Material::KINDS[number].has_functions() || purpose.served.iter().any(|kind| kind.number as usize == number)
    };
    // A fact of some kinds of material, by the reason for each kind.
    let of_materials = |name: &str, reasons: Vec<Option<Reason>>| {
        let served = reasons.iter().enumerate().filter(|(number, _)| is_served(*number));
        let served = served.flat_map(|(_, reason)| reason).next().cloned();
        [(name.to_string(), served), (format!("scene.{name}"), reasons.into_iter().flatten().next())]
    };
    for declared in DECLARED.iter() {
        if declared.is_of_materials() {
            let of_kind = |kind| reason(&format!("{}.{kind}", declared.name));
            facts.extend(of_materials(declared.name, MATERIALS.iter().map(of_kind).collect()));
        } else {
            let any = declared.facts().find_map(|fact| reason(&fact));
            facts.extend(declared.facts().map(|fact| (fact.clone(), reason(&fact))));
            facts.insert(declared.name.to_string(), any);
        }
    }
    let mut of_kinds = |name: &str, group: &str, is_so: fn(&MaterialKind) -> bool| {
        let own = |(kind, name): (&MaterialKind, &&str)| reason(&format!("{group}.{name}")).filter(|_| is_so(kind));
        facts.extend(of_materials(name, Material::KINDS.iter().zip(MATERIALS).map(own).collect()));
    };
    of_kinds("second_part", "material", |kind| !kind.second_part.is_empty());
    of_kinds("transmissive", "material", |kind| kind.is_transmissive);
    of_kinds("layered", "material", |kind| kind.can_have(ROUGH_LAYER));
    of_kinds("both_sided", "wide_lobe", |kind| kind.is_transmissive);
    of_kinds("shining", "material", |kind| kind.emits);
    let is = |name: &str, so: bool, why: Reason| (name.to_string(), so.then_some(why));
    let backgrounds = BACKGROUNDS.iter().filter(|name| features.reason(&format!("background.{name}")).is_some());
    let several_backgrounds = backgrounds.count() > 1;
    let Quantities { lights, brute_force, .. } = features.quantities;
    // Light paths end at lights that camera paths find too, or at lights without size.
    let light_paths = reason("light_paths").filter(|_| options.light_paths.count() > 0);
    facts.extend([
        ("light_paths".to_string(), light_paths),
        is("media", features.crosses_media(), Reason::EveryRender),
        is("lights", lights > 0, Reason::EveryRender),
        is("several_lights", lights > 1, Reason::EveryRender),
        is("few_primitives", brute_force, Reason::EveryRender),
        is("several_backgrounds", several_backgrounds, Reason::Requested(EVERY_FEATURE.to_string())),
        is("walk.siblings", options.walk == Walk::Siblings, Reason::EveryRender),
        is("fused", purpose.bounces.fused, Reason::EveryRender),
        is("queues", purpose.bounces.queues, Reason::Requested(QUEUES.to_string())),
        is("kernel.light_path", purpose.light_path, Reason::EveryRender),
    ]);
    // Each value of an option is a fact, such as `filter.box`. The option's name alone holds if its value is not the default.
    for spec in TRADE_OFFS {
        let (value, why) = (spec.value(options), Reason::Requested(spec.as_given(options)));
        let of_value =
            |known: &&str| is(&format!("{}.{known}", spec.name), value.as_deref() == Some(known), why.clone());
        facts.extend(spec.values.iter().map(of_value));
        facts.extend([is(spec.name, !spec.is_default(options), why.clone())]);
    }
    let given = Reason::Requested(options::AOV.as_given(options));
    let found_by = |finder: Finder| options.aov.sums().any(|sum| sum.finder() == finder);
    facts.extend([
        is("aov", options.aov.count() > 0, given.clone()),
        is("truth", options.aov.stored().next().is_some(), given.clone()),
        is("mattes", !options.aov.mattes().is_empty(), given.clone()),
        is("truth.uv", options.aov.has(Aov::Uv0), given.clone()),
        is("aov.hit", found_by(Finder::Hit), given.clone()),
        is("aov.surface", found_by(Finder::Surface), given.clone()),
        is("aov.direct", found_by(Finder::Direct), given.clone()),
        is("aov.lights", !options.aov.groups().is_empty(), given.clone()),
        is("seen.rough", options.aov.surface == SeenSurface::Rough, given),
    ]);
    for (name, when) in CONDITIONS.iter() {
        // A test asserts that all conditions are right.
        let reason = when.as_ref().ok().and_then(|when| when.reason(&facts).ok()).flatten();
        facts.insert(name.clone(), reason);
    }
    facts
}

/// A feature that a scene can need: its name, the object that needs it, and the module that is linked only for it.
pub(super) struct Known<'a> {
    pub name: String,
    pub reason: Option<&'a str>,
    pub module: String,
}

/// The features of a fact, or of a group of facts.
pub(super) fn known_of<'a>(declared: &'static Declared, features: &'a Features) -> Vec<Known<'a>> {
    let of = |(label, module): (&str, &str)| {
        let of_kinds = declared.kinds.iter().copied().zip(declared.facts());
        let facts = if label.contains("{}") { of_kinds.collect() } else { vec![("", declared.name.to_string())] };
        let known = |(kind, fact): (&str, String)| Known {
            name: label.replace("{}", kind),
            reason: features.reason(&fact).or_else(|| features.any(&fact)).map(String::as_str),
            module: module.replace("{}", if kind.is_empty() { declared.name } else { kind }),
        };
        facts.into_iter().map(known).collect()
    };
    declared.feature.map_or_else(Vec::new, of)
}

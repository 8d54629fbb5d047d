//! The choices of the plan for the directives of the shaders: facts, lists and values.

use std::collections::BTreeMap;

use super::facts::{Purpose, facts};
use super::state::{PathField, path_fields, path_layout, path_module, slots_module};
use super::tables::UniformTables;
use crate::aov::{Aovs, BACKGROUND, Finder, Sum, sums_of_group};
use crate::bitmap::FORMATS;
use crate::data::{FILM_SUMS, KIND_INSTANCE, KIND_TRIANGLE, RUN_LENGTH, SPLAT_SUMS};
use crate::flatten::{BACKGROUNDS, BOUNDARIES, FIELDS, Features, PRIMITIVES, Quantities, TEXTURES};
use crate::gpu::link::{Choices, Entry, Facts, Reason, reason_of};
use crate::lobe::{LOBES, evaluated_rows, lobes_module, numbers};
use crate::material::{MATERIALS, Material, MaterialKind, RowKind, Sets};
use crate::options::RenderOptions;
use crate::shape::{KINDS, ShapeKind, code_kind};

/// All tables but those of shapes.
const OTHER_TABLES: &str = "nodes media fields lights delta_lights light_nodes emitters aims materials textures frames";

/// The kinds of material that the scene uses.
pub(super) fn materials(features: &Features) -> Vec<Entry> {
    let reason = |name| features.reason(&format!("material.{name}")).cloned().map(Reason::Requested);
    let own = numbered(MATERIALS).zip(Material::KINDS).filter(|(_, kind)| kind.has_functions());
    closed(own.filter_map(|((number, name), _)| Some((name, number, reason(name)?))))
}

/// Kinds with their numbers. The last one closes a switch over them.
fn closed<'a>(kinds: impl Iterator<Item = (&'a str, u32, Reason)>) -> Vec<Entry> {
    let entry = |(name, number, why): (&str, u32, _)| Entry { name: name.to_string(), number, closes: false, why };
    let mut entries: Vec<_> = kinds.map(entry).collect();
    if let Some(last) = entries.last_mut() {
        last.closes = true;
    }
    entries
}

/// The kinds of a group of facts that hold, with their numbers.
fn of_group(facts: &Facts, group: &str, kinds: impl Iterator<Item = (u32, &'static str)>) -> Vec<Entry> {
    let reason = |name: &str| reason_of(facts, &format!("{group}.{name}")).cloned();
    closed(kinds.filter_map(|(number, name)| Some((name, number, reason(name)?))))
}

fn numbered(names: &[&'static str]) -> impl Iterator<Item = (u32, &'static str)> {
    (0..).zip(names.iter().copied())
}

/// The choices of a kernel that serves some of the scene's materials, and the fields of the state of paths.
pub(super) fn decide(
    features: &Features,
    options: &RenderOptions,
    tables: &UniformTables,
    materials: &[Entry],
    queue: u32,
    purpose: Purpose<'_>,
) -> (Choices, Vec<PathField>) {
    let facts = facts(features, options, purpose);
    let path_fields = path_fields(&facts, &options.aov);
    let mut lists = lists_of_shapes(&facts);
    lists.extend(lists_of_materials(features, &facts, materials, purpose.served));
    lists.extend(lists_of_sums(&facts, &options.aov));
    lists.extend(lists_of_state(&path_fields));
    let values = values(&features.quantities, options, &facts, materials.len(), queue);
    let table = |name: &str| {
        let (space, size) = match tables.uniform.get(name) {
            Some(elements) => ("uniform".to_string(), format!(", {elements}")),
            None => ("storage, read".to_string(), String::new()),
        };
        [(format!("space_of_{name}"), space), (format!("size_of_{name}"), size)]
    };
    let of_tables = OTHER_TABLES.split(' ').chain(KINDS.iter().map(|kind| kind.table.name)).flat_map(table);
    let values = values.into_iter().map(|(name, number)| (name.to_string(), number.to_string()));
    let choices = Choices {
        facts,
        lists,
        values: values.chain(of_tables).chain(numbers()).collect(),
        generated: BTreeMap::from([
            ("generated/lobes", lobes_module()),
            ("generated/path", path_module(&options.aov)),
            ("generated/slots", slots_module(&path_fields)),
        ]),
    };
    (choices, path_fields)
}

type Lists = BTreeMap<&'static str, Vec<Entry>>;

/// The kinds of object whose shapes have a fact of this group, by the tables in which objects lie. Of a mesh, that is the table of instances.
fn objects(facts: &Facts, group: &str) -> Vec<Entry> {
    let reason = |kind: &ShapeKind| reason_of(facts, &format!("{group}.{}", kind.shader)).cloned();
    let table = |kind: &ShapeKind| kind.table.name.trim_end_matches('s');
    closed((0..).zip(KINDS).filter_map(|(number, kind)| Some((table(kind), code_kind(number), reason(kind)?))))
}

/// The lists of kinds of shape, texture and background.
fn lists_of_shapes(facts: &Facts) -> Lists {
    let of_shapes = |group| of_group(facts, group, numbered(PRIMITIVES));
    let (primitive, emitter, parted) = (of_shapes("shape"), of_shapes("area_light"), of_shapes("parted"));
    let has_parts = |kind: &Entry| parted.iter().any(|other| other.number == kind.number);
    let (parted_emitter, whole_emitter): (Vec<_>, Vec<_>) = emitter.iter().cloned().partition(has_parts);
    let (paired, single): (Vec<_>, Vec<_>) = primitive.iter().cloned().partition(|kind| kind.number == KIND_TRIANGLE);
    let is_crossed = |kind: &&Entry| reason_of(facts, &format!("crossed_body.{}", kind.name)).is_some();
    let crossed_body = primitive.iter().filter(is_crossed).cloned().collect();
    let convex = BOUNDARIES.iter().filter(|own| own.1 != KIND_INSTANCE).map(|(name, kind)| (*kind, *name));
    let background = of_group(facts, "background", numbered(BACKGROUNDS));
    let (other_backgrounds, last_background) = background.split_at(background.len().saturating_sub(1));
    BTreeMap::from([
        // What rays hit: all, those that walks test in pairs, and the others.
        ("primitive", primitive),
        ("paired", paired),
        ("single", single),
        // The objects: all, those that move, and the boundaries of media that move.
        ("object", objects(facts, "shape")),
        ("moving", objects(facts, "moves")),
        ("moving_boundary", objects(facts, "boundary_moves")),
        // The shapes that are sampled as lights: all, those cut into parts, and the others.
        ("emitter", emitter),
        ("parted_emitter", parted_emitter),
        ("whole_emitter", whole_emitter),
        // The bodies that a ray leaves again through a pane or a hole of their alpha.
        ("crossed_body", crossed_body),
        // The kinds of boundary of media that a ray enters at most once.
        ("convex_boundary", of_group(facts, "boundary", convex)),
        // The densities of media that vary.
        ("varying", of_group(facts, "varying", (1..).zip(FIELDS.iter().copied()))),
        ("texture", of_group(facts, "texture", numbered(TEXTURES))),
        ("texel_format", of_group(facts, "texel", numbered(FORMATS))),
        // The last background, those before it, and all.
        ("own_background", last_background.to_vec()),
        ("other_background", other_backgrounds.to_vec()),
        ("background", background.clone()),
    ])
}

/// The lists of the materials that the kernel serves, by their properties.
fn lists_of_materials(features: &Features, facts: &Facts, materials: &[Entry], served: &[Entry]) -> Lists {
    let those = |entries: &[Entry], are: fn(&MaterialKind) -> bool| -> Vec<Entry> {
        let is_one = |kind: &&Entry| Material::KINDS.get(kind.number as usize).is_some_and(are);
        let mut found: Vec<Entry> = entries.iter().filter(is_one).cloned().collect();
        found.iter_mut().last().into_iter().for_each(|last| last.closes = true);
        found
    };
    let is_non_specular = |kind: &&Entry| features.reason(&format!("wide_lobe.{}", kind.name)).is_some();
    let non_specular: Vec<Entry> = served.iter().filter(is_non_specular).cloned().collect();
    let why = |name: &str| reason_of(facts, name).cloned();
    let of_rows = |are: fn(&RowKind) -> bool| {
        let entry = |(number, row): (u32, &'static RowKind)| Some((row.name, number, why(row.name)?));
        closed((0..).zip(evaluated_rows()).filter(|(_, row)| are(row)).filter_map(entry))
    };
    let layer = (0..).zip(LOBES).filter(|(_, lobe)| lobe.is_layer);
    let layer = closed(layer.filter_map(|(number, lobe)| Some((lobe.name(), number, why(lobe.name())?))));
    BTreeMap::from([
        ("material", served.to_vec()),
        ("both_sided", those(&non_specular, |kind| kind.is_transmissive)),
        ("non_specular", non_specular),
        ("transmissive", those(served, |kind| kind.is_transmissive)),
        // Those that take two elements of the table.
        ("two_part", those(served, |kind| !kind.second_part.is_empty())),
        // Those of the scene that can be smooth panes.
        ("pane", those(materials, |kind| kind.is_pane)),
        // The further rows that the kernel evaluates, and those of them with modules of their own.
        ("extension", of_rows(|_| true)),
        ("own_extension", of_rows(|row| row.sets == Sets::Own)),
        // The layers of glTF's material: the inner ones first, and the outer ones first.
        ("inner_layer", layer.iter().rev().cloned().collect()),
        ("layer", layer),
    ])
}

/// The lists of the sums of `--aov`: the channels of the first hit by their modules, then the components of the sums by the stage that finds them.
fn lists_of_sums(facts: &Facts, aovs: &Aovs) -> Lists {
    let sums_of = |finder: Finder, fact: &str| {
        let why = reason_of(facts, fact);
        let components = (0..).zip(aovs.sum_components()).filter(|(_, (sum, _))| sum.finder() == finder);
        let entry = |(number, (sum, name)): (u32, (Sum, String))| {
            let component = name.rsplit('.').next().unwrap_or_default().to_lowercase();
            // In the modules under shaders/aov: a function of the first hit, or a variable.
            let vector = if finder == Finder::Hit { format!("{}(path)", sum.name()) } else { sum.name().to_string() };
            let name = if sum.components().len() > 1 { format!("{vector}.{component}") } else { vector };
            Some(Entry { name, number, closes: false, why: why?.clone() })
        };
        components.filter_map(entry).collect::<Vec<Entry>>()
    };
    let of_truth = |names: Vec<&str>| {
        let why = reason_of(facts, "truth").cloned().unwrap_or(Reason::EveryRender);
        let entry =
            |(number, name): (u32, &str)| Entry { name: name.to_owned(), number, closes: false, why: why.clone() };
        (0..).zip(names).map(entry).collect::<Vec<Entry>>()
    };
    let channels = (0..).zip(aovs.sums().filter(|sum| sum.finder() == Finder::Hit));
    let channel = |(number, sum): (u32, Sum)| Some((sum.name(), number, reason_of(facts, "aov_hit")?.clone()));
    BTreeMap::from([
        ("hit_channel", closed(channels.filter_map(channel))),
        ("matte", closed(reason_of(facts, "mattes").map(|why| ("mattes", 0, why.clone())).into_iter())),
        ("hit_sum", sums_of(Finder::Hit, "aov_hit")),
        ("surface_sum", sums_of(Finder::Surface, "aov_surface")),
        ("direct_sum", sums_of(Finder::Direct, "aov.direct")),
        ("truth_channel", of_truth(aovs.stored().map(|(_, name, _)| name).collect())),
        ("truth_word", of_truth(aovs.words_of_kernels())),
    ])
}

/// The lists of the words of a path's state.
fn lists_of_state(fields: &[PathField]) -> Lists {
    let layout = path_layout(fields);
    let entries = |all: Vec<(String, u32)>| {
        let entry = |(name, number)| Entry { name, number, closes: false, why: Reason::EveryRender };
        all.into_iter().map(entry).collect::<Vec<_>>()
    };
    BTreeMap::from([
        ("path_plane", entries(layout.planes)),
        ("path_word", entries(layout.words)),
        ("other_path_word", entries(layout.others)),
    ])
}

/// The numbers behind `${…}`.
fn values(
    own: &Quantities,
    options: &RenderOptions,
    facts: &Facts,
    queues: usize,
    queue: u32,
) -> Vec<(&'static str, u32)> {
    let has = |fact: &str| reason_of(facts, fact).is_some();
    let extensions = evaluated_rows().filter(|row| has(row.name)).count() as u32;
    let mattes = options.aov.mattes().len() as u32;
    let traces_light = options.light_paths.count() > 0;
    let (splat_sums, on_film) = (if traces_light { SPLAT_SUMS } else { 0 }, options.aov.count_on_film(traces_light));
    let background = options.aov.groups().iter().position(|group| group == BACKGROUND);
    vec![
        // WGSL has no empty arrays.
        ("stack_size", own.stack_size + 1),
        ("boundary_stack_size", own.boundary_stack_size + 1),
        ("fisheye", own.fisheye),
        ("media", own.media),
        ("sky_light", own.sky_light),
        ("sky_columns", own.sky_grid.0),
        ("sky_rows", own.sky_grid.1),
        // Mesa 22.3 allows an invocation 65,535 iterations: for one walk, or for two, the other being a shadow ray's. A step that reads
        // an alpha has four more, one for each texel, on both sides of a body, and one at what moves has those of its pose.
        (
            "most_steps",
            if own.shadow_rays { 19_000 } else { 48_000 }
                / if own.alpha_textures { 5 } else { 1 }
                / if own.alpha_on_bodies { 3 } else { 1 }
                / (1 + own.motion_iterations),
        ),
        // The iterations that count for passing a pane: those of the longest texture, or some for its material.
        ("pane_steps", if own.pane_textures { 384 } else { 8 }),
        // Seven octaves of noise over eight corners, for each texture of a material, five at least, and one of a light; the parts of a
        // light; and the exchanges of each kind of matte.
        ("iterations_of_shading", 64 * (extensions.max(5) + 1 + u32::from(has("parted")) + mattes)),
        ("run_length", RUN_LENGTH),
        ("matte_kinds", mattes),
        ("stored_words", options.aov.words_of_kernels().len() as u32),
        // The sums of a pixel of the film, and the `--aov` sums of a path.
        ("film_sums", (FILM_SUMS + on_film + splat_sums) as u32),
        ("splat_sums", (FILM_SUMS + on_film) as u32),
        ("plain_sums", options.aov.plain_count() as u32),
        // The groups of lights, the sums of each on the film, and where their numbers begin in the table of groups.
        ("light_groups", options.aov.groups().len() as u32),
        ("sums_of_group", sums_of_group(traces_light) as u32),
        ("words_of_groups", options.aov.groups().len().div_ceil(32) as u32),
        ("background_group", background.unwrap_or_default() as u32),
        ("delta_lights", own.delta_lights),
        ("lights", own.lights),
        ("aims", own.aims),
        ("first_delta_light", own.first_delta_light),
        ("narrow_lobes", u32::from(has("scene.narrow_lobe"))),
        ("path_sums", options.aov.count().max(1) as u32),
        ("queues", queues as u32),
        ("queue", queue),
    ]
}

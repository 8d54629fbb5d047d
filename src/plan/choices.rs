//! The choices of the plan for the directives of the shaders: conditions, lists, modules and values, each with its reason.

use std::collections::BTreeMap;

use super::state::{Needs, PathField, path_fields, path_layout, path_module, slots_module};
use super::tables::UniformTables;
use crate::aov::{Finder, SeenSurface, Sum};
use crate::bitmap::FORMATS;
use crate::data::{FILM_SUMS, KIND_INSTANCE, KIND_TRIANGLE, RUN_LENGTH, SPLAT_SUMS};
use crate::flatten::{BACKGROUNDS, BOUNDARIES, EVERY_FEATURE, Features, PRIMITIVES, TEXTURES};
use crate::gpu::link::{Choices, Chosen, Entry, Reason};
use crate::material::{ExtensionKind, Material};
use crate::options::{self, FeatureSet, Filter, OptionSpec, RenderOptions};
use crate::shape::KINDS;

/// The reason for kernels and modules that sort slots into queues.
pub(super) const QUEUES: &str = "--scatter queues";

/// How the stages of a bounce are split into kernels.
#[derive(Clone, Copy)]
pub(super) struct Bounces {
    pub fused: bool,
    pub queues: bool,
}

/// The choices that `plan` lists: between modules that do one job in different ways. The other choices switch a feature on or off.
pub const ALTERNATIVES: [&str; 16] = [
    "axes",
    "camera",
    "filter",
    "colour",
    "uv",
    "shading",
    "layer",
    "medium_albedo",
    "roulette",
    "probe",
    "light_choice",
    "clamp",
    "fresnel",
    "sphere_chord",
    "walk",
    "sampler",
];

macro_rules! tables {
    ($($name:literal),*) => { [$(($name, concat!("space_of_", $name), concat!("size_of_", $name))),*] };
}
/// All tables but those of shapes: the name, and the names of the values for its address space and its size.
const OTHER_TABLES: [(&str, &str, &str); 10] = tables![
    "nodes",
    "media",
    "lights",
    "delta_lights",
    "light_nodes",
    "emitters",
    "aims",
    "materials",
    "textures",
    "frames"
];

/// The choices of a kernel, and what the plan needs to know of them.
pub(super) struct Decided {
    pub choices: Choices,
    pub path_fields: Vec<PathField>,
    /// The reasons for kernels that only some scenes have.
    pub surface: Option<Reason>,
    pub medium: Option<Reason>,
    pub light: Option<Reason>,
    pub queue: Option<Reason>,
    pub light_paths: Option<Reason>,
}

/// The first object that needs one of these features.
fn first_reason<'a>(used: impl IntoIterator<Item = &'a Option<String>>) -> Option<Reason> {
    used.into_iter().flatten().next().cloned().map(Reason::Requested)
}

fn reason_of(used: &Option<String>) -> Option<Reason> {
    first_reason([used])
}

fn option(text: &str) -> Reason {
    Reason::Requested(text.to_string())
}

/// A module of every render.
fn usual(module: &'static str) -> Chosen {
    Chosen { module, why: Reason::EveryRender }
}

/// `module` if there is a reason for it, else `other`, such as its null module.
fn either(why: &Option<Reason>, module: &'static str, other: &'static str) -> Chosen {
    why.clone().map_or(usual(other), |why| Chosen { module, why })
}

/// The kinds that the scene uses; a kind's number is the index of its name. The last one closes a switch over them.
pub(super) fn entries(names: &[&str], used: &[Option<String>]) -> Vec<Entry> {
    let kinds = (0..).zip(names).zip(used);
    closed(kinds.filter_map(|((number, name), used)| Some((*name, number, reason_of(used)?))))
}

fn closed<'a>(kinds: impl Iterator<Item = (&'a str, u32, Reason)>) -> Vec<Entry> {
    let entry = |(name, number, why): (&str, u32, _)| Entry { name: name.to_string(), number, closes: false, why };
    let mut entries: Vec<_> = kinds.map(entry).collect();
    if let Some(last) = entries.last_mut() {
        last.closes = true;
    }
    entries
}

/// Splits meshes from the other kinds: the reason for meshes, and the others. If there are meshes, their case closes a switch.
fn split_meshes(kinds: Vec<Entry>) -> (Option<Reason>, Vec<Entry>) {
    let (meshes, mut others): (Vec<_>, Vec<_>) =
        kinds.into_iter().partition(|kind| [KIND_TRIANGLE, KIND_INSTANCE].contains(&kind.number));
    others.iter_mut().for_each(|kind| kind.closes &= meshes.is_empty());
    (meshes.into_iter().next().map(|mesh| mesh.why), others)
}

/// The choices of a kernel that serves some of the scene's materials, and the queue with this index if slots are sorted into queues.
pub(super) fn decide(
    features: &Features,
    options: &RenderOptions,
    tables: &UniformTables,
    materials: &[Entry],
    served: &[Entry],
    queue: u32,
    bounces: Bounces,
) -> Decided {
    let Bounces { fused, queues } = bounces;
    let if_so = |condition: bool, why: Reason| condition.then_some(why);
    let by_option = |spec: &OptionSpec| Chosen { module: spec.module(options), why: option(&spec.as_given(options)) };
    // An approximation is linked only if the scene has what it applies to.
    let approximate = |spec: &OptionSpec, in_scene: bool| match in_scene && !spec.is_default(options) {
        true => by_option(spec),
        false => usual(spec.module(&RenderOptions::default())),
    };
    let (mesh, primitive) = split_meshes(entries(PRIMITIVES, &features.primitives));
    let (moving_mesh, moving) = split_meshes(entries(PRIMITIVES, &features.motions));
    let (emitting_mesh, emitter) = split_meshes(entries(PRIMITIVES, &features.emitters));
    let (parted_mesh, parted) = split_meshes(entries(PRIMITIVES, &features.parted));
    let has_parts = |kind: &Entry| parted.iter().any(|other| other.number == kind.number);
    let (parted_emitter, whole_emitter): (Vec<_>, Vec<_>) = emitter.iter().cloned().partition(has_parts);
    let parted_light = first_reason(&features.parted);
    let crossed_light = reason_of(&features.crossed_lights);
    let boundaries = BOUNDARIES.iter().zip(&features.boundaries);
    let boundaries = boundaries.filter_map(|((name, kind), used)| Some((*name, *kind, reason_of(used)?)));
    let (mesh_boundary, convex_boundary) = split_meshes(closed(boundaries));
    let texture = entries(TEXTURES, &features.textures);
    let texel_format = entries(FORMATS, &features.texel_formats);
    let background = entries(BACKGROUNDS, &features.backgrounds);
    let (own_background, other_background) = match background.split_last() {
        Some((own, others)) => (vec![own.clone()], others.to_vec()),
        None => (Vec::new(), Vec::new()),
    };

    let emitting_surface = first_reason(&features.emitters);
    let emitting_sky = reason_of(&features.emitting_sky);
    let delta_light = reason_of(&features.delta_lights);
    let any_light = first_reason([&features.emitting_sky, &features.delta_lights]);
    let any_light = emitting_surface.clone().or(any_light).unwrap_or(Reason::EveryRender);
    let light = if_so(features.lights > 0, any_light);
    let medium = if_so(features.crosses_media(), first_reason(&features.boundaries).unwrap_or(Reason::EveryRender));
    let surface = materials.first().map(|kind| kind.why.clone());
    // A mesh makes walks long.
    let hit = mesh.clone().or(first_reason(&features.primitives)).unwrap_or(Reason::EveryRender);
    let brute_force = if_so(surface.is_some() && features.brute_force, hit.clone());
    let walk = match (&surface, &brute_force) {
        (None, _) => usual("scene/nothing"),
        (Some(_), Some(_)) => Chosen { module: "scene/brute_force", why: hit },
        (Some(_), None) => Chosen { module: "scene/traverse", why: hit },
    };
    let served_in = |used: &[Option<String>]| -> Vec<Entry> {
        let is_in = |kind: &&Entry| used.get(kind.number as usize).is_some_and(Option::is_some);
        served.iter().filter(is_in).cloned().collect()
    };
    let non_specular = served_in(&features.non_specular);
    let surface_samples_light = light.clone().filter(|_| !non_specular.is_empty());
    let any_narrow = first_reason(&features.narrow).or(reason_of(&features.narrow_media));
    let hidden = any_narrow.or(first_reason(&features.specular));
    let probed = light.clone().and(hidden);
    let of_first = |used: &[Option<String>]| served_in(used).first().map(|kind| kind.why.clone());
    let sends_probe = probed.clone().and(of_first(&features.narrow).or(of_first(&features.specular)));
    let sends_shadow_ray = surface_samples_light.or(sends_probe);
    let of_kind = |kind: &Entry| Material::KINDS.get(kind.number as usize);
    let two_part: Vec<Entry> =
        served.iter().filter(|kind| of_kind(kind).is_some_and(|kind| kind.has_second_part)).cloned().collect();
    let is_transmissive = |kind: &&Entry| of_kind(kind).is_some_and(|kind| kind.is_transmissive);
    let both_sided: Vec<Entry> = non_specular.iter().filter(is_transmissive).cloned().collect();
    let shines = served.iter().any(|kind| of_kind(kind).is_some_and(|kind| kind.emits));

    let event = surface.clone().or(medium.clone());
    let given_aov = options::AOV.as_given(options);
    let aov = |finder: Finder, there: &Option<Reason>| {
        let needed = there.is_some() && options.aov.sums().any(|sum| sum.finder() == finder);
        if_so(needed, option(&given_aov))
    };
    let (aov_surface, aov_hit) = (aov(Finder::Surface, &event), aov(Finder::Hit, &surface));
    let aov_direct = aov(Finder::Direct, &Some(Reason::EveryRender));
    let aov_rough = aov_surface.clone().filter(|_| options.aov.surface == SeenSurface::Rough);
    let own = |extension: ExtensionKind| of_first(&features.extensions[extension as usize]);
    let scene_has = |extension: ExtensionKind| first_reason(&features.extensions[extension as usize]);
    let extensions = [
        ("emission", ExtensionKind::Emission),
        ("roughness", ExtensionKind::Roughness),
        ("metallic", ExtensionKind::Metallic),
        ("normal", ExtensionKind::Normal),
        ("specular", ExtensionKind::Specular),
        ("specular_share", ExtensionKind::SpecularShare),
        ("transmission", ExtensionKind::Transmission),
        ("coat", ExtensionKind::Coat),
        ("coat_roughness", ExtensionKind::CoatRoughness),
        ("coat_normal", ExtensionKind::CoatNormal),
        ("sheen", ExtensionKind::Sheen),
        ("sheen_roughness", ExtensionKind::SheenRoughness),
        ("anisotropy", ExtensionKind::Anisotropy),
        ("iridescence", ExtensionKind::Iridescence),
        ("iridescence_thickness", ExtensionKind::IridescenceThickness),
        ("diffuse_transmission", ExtensionKind::DiffuseTransmission),
        ("diffuse_transmission_share", ExtensionKind::DiffuseTransmissionShare),
        ("dispersion", ExtensionKind::Dispersion),
    ];
    let extension =
        closed((0..).zip(extensions).filter_map(|(number, (name, extension))| Some((name, number, own(extension)?))));
    let extension_count = extension.len() as u32;
    let anisotropy = own(ExtensionKind::Anisotropy);
    let (own_emission, normal_map) = (own(ExtensionKind::Emission), own(ExtensionKind::Normal));
    let (multiscatter, own_layer) = (own(ExtensionKind::Multiscatter), own(ExtensionKind::Specular));
    let [transmission, coat, coat_normal, sheen] =
        [ExtensionKind::Transmission, ExtensionKind::Coat, ExtensionKind::CoatNormal, ExtensionKind::Sheen].map(own);
    let [film, through, dispersion] =
        [ExtensionKind::Iridescence, ExtensionKind::DiffuseTransmission, ExtensionKind::Dispersion].map(own);
    let (tinted, absorbing) = (of_first(&features.tinted), of_first(&features.absorbing));
    let vertex_colours = mesh.clone().and(own(ExtensionKind::VertexColours));
    let evaluated = extension.first().map(|entry| entry.why.clone()).or(vertex_colours.clone());

    let emission = scene_has(ExtensionKind::Emission);
    // Extensions whose texture is a number.
    let numbers = [
        ExtensionKind::Roughness,
        ExtensionKind::Metallic,
        ExtensionKind::Alpha,
        ExtensionKind::SpecularShare,
        ExtensionKind::Transmission,
        ExtensionKind::Coat,
        ExtensionKind::CoatRoughness,
        ExtensionKind::SheenRoughness,
        ExtensionKind::Iridescence,
        ExtensionKind::IridescenceThickness,
        ExtensionKind::DiffuseTransmissionShare,
    ];
    let number_images = numbers.into_iter().find_map(scene_has);
    let alpha = surface.clone().and(scene_has(ExtensionKind::Alpha));
    // Smooth panes. Of a body, a ray passes both sides.
    let pane = surface.clone().and(first_reason(&features.panes));
    let textured_pane = pane.clone().filter(|_| features.pane_textures || options.features == FeatureSet::All);
    // Bodies with an alpha, in the same way.
    let alpha_body = alpha.clone().and(first_reason(&features.alpha_bodies));
    let lets_pass = |kind: usize| {
        pane.is_some() && features.panes[kind].is_some()
            || alpha_body.is_some() && features.alpha_bodies[kind].is_some()
    };
    let crossed_body: Vec<Entry> = (primitive.iter())
        .filter(|kind| KINDS[kind.number as usize].encloses() && lets_pass(kind.number as usize))
        .cloned()
        .collect();
    let body = crossed_body.first().map(|kind| kind.why.clone());
    let panes: Vec<Entry> =
        materials.iter().filter(|kind| of_kind(kind).is_some_and(|kind| kind.is_pane)).cloned().collect();
    let vertex_emission = mesh.clone().and(scene_has(ExtensionKind::VertexEmission));
    let vertex_alpha = alpha.clone().and(mesh.clone()).and(scene_has(ExtensionKind::VertexAlpha));
    let uv_tables = mesh.clone().and(reason_of(&features.uv_tables));
    let both_sides = both_sided.first().map(|kind| kind.why.clone()).or(transmission.clone()).or(through.clone());
    let both_sides = both_sides.filter(|_| light.is_some() && features.smooth.is_some());
    let emits = shines.then_some(Reason::EveryRender).or(own_emission.clone());
    let found_light = light.clone().and(emits).and(emitting_surface.clone());
    let light_coverage = alpha.clone().and(emission.clone()).and(emitting_surface.clone());
    let sampled_light = light.clone().or(emission.clone());
    let staged = |why: &Option<Reason>| why.clone().filter(|_| !fused);
    let queue_why = if_so(queues, option(QUEUES));
    let negative_lobes = if_so(options.filter == Filter::Mitchell, by_option(&options::FILTER).why);

    // Light paths end at lights that camera paths find too, or at lights without size.
    let light_paths = reason_of(&features.light_paths).filter(|_| options.light_paths.count() > 0);
    let sampled_ratio = light_paths.clone().and(first_reason(&features.narrow));
    let light_absorption = light_paths.clone().and(first_reason(&features.absorbing));
    let any_aov = if_so(!options.aov.is_empty(), option(&given_aov));
    let needs = Needs {
        is_staged: !fused,
        light: light.clone(),
        instance: mesh.clone().or(body.clone()),
        light_instance: emitting_mesh.clone().or(crossed_light.clone()),
        probed: probed.clone(),
        light_paths: light_paths.clone(),
        sampled_ratio: sampled_ratio.clone(),
        light_absorption: light_absorption.clone(),
        event: event.clone(),
        sampled_light: sampled_light.clone(),
        aov_hit: aov_hit.clone(),
        aov_rough: aov_rough.clone(),
        aov_surface: aov_surface.clone(),
        aov_direct: aov_direct.clone(),
    };
    let path_fields = path_fields(&needs, &options.aov);
    let sums_of = |finder: Finder, why: &Option<Reason>| {
        let components = (0..).zip(options.aov.sum_components()).filter(|(_, (sum, _))| sum.finder() == finder);
        let entry = |(number, (sum, name)): (u32, (Sum, String))| {
            let component = name.rsplit('.').next().unwrap_or_default().to_lowercase();
            // In the modules under shaders/aov: a function of the first hit, or a variable.
            let vector = if finder == Finder::Hit { format!("{}(path)", sum.name()) } else { sum.name().to_string() };
            let name = if sum.components().len() > 1 { format!("{vector}.{component}") } else { vector };
            Some(Entry { name, number, closes: false, why: why.clone()? })
        };
        components.filter_map(entry).collect::<Vec<Entry>>()
    };
    let hit_channel = options.aov.sums().filter(|sum| sum.finder() == Finder::Hit);
    let hit_channel = closed((0..).zip(hit_channel).filter_map(|(i, sum)| Some((sum.name(), i, aov_hit.clone()?))));
    let is_clamped = options.clamp.is_some() && (surface.is_some() || features.media > 0);
    let not_sampled = match &features.not_sampled {
        Some(left) => Some(option(&left.reason)),
        None => if_so(options.features == FeatureSet::All, option(EVERY_FEATURE)),
    };
    // The conditions of `//@ if`.
    let conditions = [
        // A mesh bounds a medium.
        ("mesh_boundary", mesh_boundary),
        ("lens", reason_of(&features.thin_lens)),
        // Render space has the camera's axes.
        ("camera_axes", reason_of(&features.camera_axes)),
        // Contributions of indirect light are limited.
        ("clamp", if_so(is_clamped, by_option(&options::CLAMP).why)),
        ("gradient_background", reason_of(&features.backgrounds[1])),
        ("image_background", reason_of(&features.backgrounds[2])),
        ("several_backgrounds", if_so(!other_background.is_empty(), option(EVERY_FEATURE))),
        // Something that emits is not sampled.
        ("not_sampled", not_sampled),
        // Normal maps on smooth meshes have tangents in their tables.
        ("vertex_tangents", uv_tables.clone().and(reason_of(&features.vertex_tangents))),
        // Meshes have several tables of texture coordinates.
        ("uv_tables", uv_tables),
        // A number of some material may be that of an image.
        ("number_images", number_images),
        // Lights at infinity are sampled: the sky or directional lights.
        ("light_at_infinity", emitting_sky.clone().or(reason_of(&features.directional_lights))),
        // Lights without size are sampled.
        ("delta_light", delta_light.clone()),
        // Probes count the light that narrow lobes hide.
        ("probed", probed.clone()),
        // Light paths are traced.
        ("light_paths", light_paths.clone()),
        ("mesh", mesh),
        // A mesh moves.
        ("moving_mesh", moving_mesh),
        // Every ray tests all primitives.
        ("brute_force", brute_force),
        // Faces of meshes are cut into parts as lights.
        ("parted_mesh", parted_mesh.clone()),
        // Faces of meshes are sampled as lights.
        ("emitting_mesh", emitting_mesh),
        // The film has channels of `--aov`.
        ("aov", any_aov.clone()),
    ];
    let transmissive: Vec<Entry> = served.iter().filter(is_transmissive).cloned().collect();
    let has_glass =
        materials.iter().any(|kind| is_transmissive(&kind)) || scene_has(ExtensionKind::Transmission).is_some();
    let has_spheres = primitive.iter().chain(&convex_boundary).any(|kind| kind.name == "sphere");
    let layout = path_layout(&path_fields);
    let numbered = |all: Vec<(String, u32)>| {
        let entry = |(name, number)| Entry { name, number, closes: false, why: Reason::EveryRender };
        all.into_iter().map(entry).collect::<Vec<_>>()
    };
    let image_texture = texture.iter().find(|kind| kind.name == "image").map(|kind| kind.why.clone());
    let second_parts = two_part.first().map(|kind| kind.why.clone());
    let surface_light = match (&light, sends_shadow_ray) {
        (None, _) => usual("null/surface_light"),
        (Some(_), None) => usual("step/specular_event"),
        (Some(_), Some(why)) => Chosen { module: "step/surface_light", why },
    };
    let queue_of_hits = queue_why.clone().filter(|_| medium.is_none());
    let moving_object = first_reason(&features.motions);
    let moving_boundary = first_reason(&features.moving_boundaries);
    let others = [&features.moving_camera, &features.moving_lights, &features.moving_media];
    let motion = moving_object.clone().or(moving_boundary.clone()).or(first_reason(others));
    let moved = |kind: &str, module, other| {
        let number = PRIMITIVES.iter().position(|name| *name == kind);
        let used =
            [&features.motions, &features.moving_boundaries].map(|used| number.and_then(|n| reason_of(&used[n])));
        either(&used.into_iter().flatten().next(), module, other)
    };
    let tint = match &dispersion {
        Some(_) => either(&dispersion, "scene/dispersed_tint", "null/tint"),
        None => either(&tinted, "scene/tint", "null/tint"),
    };
    // The modules behind `choice/…`.
    let modules = [
        ("axes", either(&reason_of(&features.camera_axes), "scene/camera_axes", "scene/world_axes")),
        ("camera", either(&reason_of(&features.thin_lens), "camera/thin_lens", "camera/pinhole")),
        ("camera_pose", either(&reason_of(&features.moving_camera), "camera/moving", "camera/resting")),
        // What moves.
        ("time", either(&motion, "motion/time", "null/time")),
        ("pose", either(&moving_object, "motion/objects", "null/pose")),
        ("pose_of_boundary", either(&moving_boundary, "motion/boundaries", "null/pose_of_boundary")),
        ("moved_sphere", moved("sphere", "motion/sphere", "null/moved_sphere")),
        ("moved_large_sphere", moved("large_sphere", "motion/large_sphere", "null/moved_large_sphere")),
        ("moved_quad", moved("quad", "motion/quad", "null/moved_quad")),
        ("moved_disk", moved("disk", "motion/disk", "null/moved_disk")),
        ("moved_cuboid", moved("cuboid", "motion/cuboid", "null/moved_cuboid")),
        ("moved_instance", moved("triangle", "motion/instance", "null/moved_instance")),
        (
            "moved_delta_light",
            either(&reason_of(&features.moving_lights), "motion/delta_light", "null/moved_delta_light"),
        ),
        ("moved_medium", either(&reason_of(&features.moving_media), "motion/medium", "null/moved_medium")),
        ("filter", by_option(&options::FILTER)),
        ("filter_weight", either(&negative_lobes, "step/filter_weight", "null/filter_weight")),
        ("colour", either(&first_reason(&features.textures), "scene/textured_colour", "scene/plain_colour")),
        ("uv", either(&image_texture, "scene/uv", "null/uv")),
        ("shading", either(&reason_of(&features.smooth), "scene/smooth_shading", "scene/flat_shading")),
        ("evaluation", either(&evaluated, "scene/evaluated_material", "scene/plain_material")),
        ("vertex_colours", either(&vertex_colours, "scene/vertex_colours", "null/vertex_colours")),
        ("normal_map", either(&normal_map, "scene/normal_map", "null/normal_map")),
        ("second_parts", either(&second_parts, "scene/second_parts", "null/second_parts")),
        ("multiscatter", either(&multiscatter, "scene/multiscatter", "null/multiscatter")),
        // The layer of glTF's material.
        ("layer", either(&own_layer, "material/pbr_own_layer", "material/pbr_plain_layer")),
        // What glTF's material has around its base.
        ("transmission", either(&transmission, "material/pbr_transmission", "null/pbr_transmission")),
        ("sheen", either(&sheen, "material/pbr_sheen", "null/pbr_sheen")),
        ("coat", either(&coat, "material/pbr_coat", "null/pbr_coat")),
        ("coat_normal", either(&coat_normal, "scene/coat_normal", "null/coat_normal")),
        ("light_coat", either(&coat.clone().and(emission.clone()), "scene/light_coat", "null/light_coat")),
        ("film", either(&film, "material/thin_film", "null/thin_film")),
        ("body", either(&through, "material/pbr_translucent_body", "material/pbr_opaque_body")),
        // Glass whose index depends on the channel.
        ("boundary", either(&dispersion, "material/dispersed_boundary", "material/plain_boundary")),
        ("followed_channel", either(&dispersion, "step/followed_channel", "null/followed_channel")),
        // The microfacets of metals, of rough glass and of glTF's material.
        ("facets", either(&anisotropy, "material/anisotropic_facets", "material/isotropic_facets")),
        ("facet_tangent", either(&anisotropy, "scene/facet_tangent", "null/facet_tangent")),
        ("tint", tint),
        ("absorption", either(&absorbing, "scene/absorption", "null/absorption")),
        ("stops", either(&alpha_body, "scene/body_stops", either(&alpha, "scene/flat_stops", "null/stops").module)),
        ("coverage", either(&alpha, "scene/coverage", "null/coverage")),
        ("vertex_alpha", either(&vertex_alpha, "scene/vertex_alpha", "null/vertex_alpha")),
        ("vertex_emission", either(&vertex_emission, "scene/vertex_emission", "null/vertex_emission")),
        ("panes", either(&pane, "step/panes", "step/no_panes")),
        ("passed_panes", either(&pane, "scene/passed_panes", "null/passed_panes")),
        ("pane_evaluation", either(&textured_pane, "scene/textured_pane", "scene/plain_pane")),
        ("crossings", either(&body, "scene/crossings", "null/crossings")),
        ("flight_end", either(&pane.clone().and(medium.clone()), "step/flight_end", "null/flight_end")),
        ("media", either(&medium, "step/media", "null/media")),
        ("medium_albedo", either(&reason_of(&features.textured_media), "scene/textured_medium", "scene/plain_medium")),
        ("transmittance", either(&medium, "scene/transmittance", "null/transmittance")),
        ("scatter", either(&surface, "step/scatter", "null/scatter")),
        ("roulette", by_option(&options::ROULETTE)),
        // Light sampling: modules that send shadow rays or trace them.
        ("surface_light", surface_light),
        ("medium_light", either(&light, "step/medium_light", "null/medium_light")),
        ("shadow", either(&light, "step/light", "null/shadow")),
        ("both_sides", either(&both_sides, "scene/both_sides", "null/both_sides")),
        ("probe", either(&probed, "step/narrow_lobe", "null/narrow_lobe")),
        // Light that BSDF sampling finds, with its MIS weight.
        ("surface_emission", either(&own_emission, "step/surface_emission", "null/surface_emission")),
        ("found_light", either(&found_light, "step/found_light", "null/found_light")),
        ("found_sky", either(&emitting_sky, "step/found_sky", "null/found_sky")),
        // Camera paths beside light paths, and what only light paths have.
        ("density_ratio", either(&light_paths, "step/density_ratio", "null/density_ratio")),
        ("light_absorption", usual("null/light_absorption")),
        ("depth_limit", usual("step/camera_depth")),
        ("delta_emission", either(&delta_light, "scene/delta_emission", "null/delta_emission")),
        ("splat_filter", usual(options.filter.splat_module())),
        ("filter_value", usual(options.filter.value_module())),
        ("sampled_light", either(&sampled_light, "step/sampled_light", "null/sampled_light")),
        // Kinds of lights.
        ("light_choice", usual(if features.lights > 1 { "scene/light_tree" } else { "scene/one_light" })),
        ("light_parts", either(&parted_light, "scene/light_parts", "null/light_parts")),
        ("light_crossings", either(&crossed_light, "scene/light_crossings", "null/light_crossings")),
        ("face_parts", either(&parted_mesh, "scene/face_parts", "null/face_parts")),
        ("delta_lights", either(&delta_light, "scene/delta_lights", "null/delta_lights")),
        ("sky_light", either(&emitting_sky, "scene/sky_light", "null/sky_light")),
        ("light_surfaces", either(&emitting_surface, "scene/light_surfaces", "null/light_surfaces")),
        ("surface_radiance", either(&emission, "scene/emitted_by_extension", "scene/emitted")),
        ("light_colour", either(&reason_of(&features.textured_lights), "scene/textured_light", "scene/plain_light")),
        ("light_coverage", either(&light_coverage, "scene/light_coverage", "null/light_coverage")),
        ("clamp", approximate(&options::CLAMP, is_clamped)),
        ("fresnel", approximate(&options::FRESNEL, has_glass)),
        ("sphere_chord", approximate(&options::PRECISION, has_spheres)),
        ("walk", walk),
        ("sampler", by_option(&options::SAMPLER)),
        // Channels of `--aov`.
        ("aov_hit", either(&aov_hit, "aov/hit", "null/aov_hit")),
        ("aov_surface", either(&aov_surface, "aov/surface", "null/aov_surface")),
        ("seen", either(&aov_rough, "aov/seen_rough", "aov/seen_first")),
        ("aov_direct", either(&aov_direct, "aov/direct", "null/aov_direct")),
        ("aov_record", either(&any_aov, "aov/record", "null/aov_record")),
        ("aov_film", either(&any_aov, "aov/film", "null/aov_film")),
        // Modules that only separate stages have.
        ("aov_hit_slot", either(&aov_hit, "slots/aov_hit", "null/aov_hit_slot")),
        ("aov_direct_slot", either(&aov_direct, "slots/aov_direct", "null/aov_direct_slot")),
        ("walker_slot", either(&alpha.clone().or(pane.clone()).or(motion.clone()), "slots/walker", "null/walker_slot")),
        ("pane_slot", either(&pane, "slots/pane", "null/pane_slot")),
        ("shadow_slot", either(&staged(&light), "slots/shadow", "null/shadow_slot")),
        ("probe_slot", either(&probed, "slots/probe", "null/probe_slot")),
        ("queue_of_hits", either(&queue_of_hits, "slots/sort_by_material", "null/sort")),
        ("queue_of_events", either(&queue_why, "slots/sort_by_material", "null/sort")),
        ("queued_slot", either(&queue_why, "slots/queued_slot", "slots/own_slot")),
    ];
    // The lists of `//@ each`.
    let lists = [
        // The kinds of primitive but for faces of meshes, which have the condition `mesh`.
        ("primitive", primitive),
        // The kinds of primitive that move, but for meshes.
        ("moving", moving),
        // The kinds of primitive that are sampled as lights, but for faces of meshes.
        ("emitter", emitter),
        // Those of them whose lights are cut into parts, and the others.
        ("parted_emitter", parted_emitter),
        ("whole_emitter", whole_emitter),
        // The kinds of boundary of media, but for meshes.
        ("convex_boundary", convex_boundary),
        // The materials that can be smooth panes, and the kinds of primitive with one that a ray leaves again.
        ("pane", panes),
        ("crossed_body", crossed_body),
        // The materials that the kernel serves.
        ("material", served.to_vec()),
        ("non_specular", non_specular),
        // The materials of the kernel that take two elements of the table.
        ("two_part", two_part),
        // The non-specular materials of the kernel that respond to light from both sides.
        ("both_sided", both_sided),
        // The extensions of a material that the kernel evaluates.
        ("extension", extension),
        // The channels of the first hit by their modules, then the components of the sums: of the first hit, of the seen surface, of direct light.
        ("hit_channel", hit_channel),
        ("hit_sum", sums_of(Finder::Hit, &aov_hit)),
        ("surface_sum", sums_of(Finder::Surface, &aov_surface)),
        ("direct_sum", sums_of(Finder::Direct, &aov_direct)),
        ("transmissive", transmissive),
        ("texture", texture),
        // The formats of the images' texels.
        ("texel_format", texel_format),
        ("background", background),
        // The last background, and those before it.
        ("own_background", own_background),
        ("other_background", other_background),
        ("path_plane", numbered(layout.planes)),
        ("path_word", numbered(layout.words)),
        ("other_path_word", numbered(layout.others)),
    ];
    let splat_sums = if options.light_paths.count() > 0 { SPLAT_SUMS } else { 0 };
    // The numbers behind `${…}`.
    let values = [
        // WGSL has no empty arrays.
        ("stack_size", features.stack_size + 1),
        ("boundary_stack_size", features.boundary_stack_size + 1),
        ("media", features.media),
        ("sky_light", features.sky_light),
        ("sky_columns", features.sky_grid.0),
        ("sky_rows", features.sky_grid.1),
        // Mesa 22.3 allows an invocation 65,535 iterations: for one walk, or for two, the other being a shadow ray's. A step that reads
        // an alpha has four more, one for each texel, on both sides of a body, and one at what moves has those of its pose.
        (
            "most_steps",
            if features.shadow_rays { 19_000 } else { 48_000 }
                / if features.alpha_textures { 5 } else { 1 }
                / if features.alpha_on_bodies { 3 } else { 1 }
                / (1 + features.motion_iterations),
        ),
        // The iterations that count for passing a pane: those of the longest texture, or some for its material.
        ("pane_steps", if features.pane_textures { 384 } else { 8 }),
        // Seven octaves of noise over eight corners, for each texture of a material, five at least, and one of a light; and the parts of a
        // light.
        ("iterations_of_shading", 64 * (extension_count.max(5) + 1 + u32::from(parted_light.is_some()))),
        ("run_length", RUN_LENGTH),
        // The sums of a pixel of the film, and the `--aov` sums of a path.
        ("film_sums", (FILM_SUMS + options.aov.count() + splat_sums) as u32),
        ("splat_sums", (FILM_SUMS + options.aov.count()) as u32),
        ("lights", features.lights),
        ("aims", features.aims),
        ("first_delta_light", features.first_delta_light),
        ("narrow_lobes", u32::from(features.narrow.iter().any(Option::is_some))),
        ("path_sums", options.aov.count().max(1) as u32),
        ("queues", materials.len() as u32),
        ("queue", queue),
    ];
    let table = |(name, space, size)| match tables.uniform.get(name) {
        Some(elements) => [(space, "uniform".to_string()), (size, format!(", {elements}"))],
        None => [(space, "storage, read".to_string()), (size, String::new())],
    };
    let of_shapes = KINDS.iter().map(|kind| (kind.table.name, kind.table.space, kind.table.size));
    let of_tables = OTHER_TABLES.into_iter().chain(of_shapes).flat_map(table);
    let values = values.into_iter().map(|(name, number)| (name, number.to_string()));
    let choices = Choices {
        conditions: BTreeMap::from(conditions),
        lists: BTreeMap::from(lists),
        modules: BTreeMap::from(modules),
        values: values.chain(of_tables).collect(),
        generated: BTreeMap::from([
            ("generated/path", path_module(&options.aov)),
            ("generated/slots", slots_module(&path_fields)),
        ]),
    };
    Decided { choices, path_fields, surface, medium, light, queue: queue_why, light_paths }
}

/// The choices of the kernel of light paths, by those of the kernels of camera paths.
pub(super) fn of_light_paths(choices: &Choices) -> Choices {
    let mut own = choices.clone();
    let absorbs = own.modules.get("absorption").is_some_and(|chosen| chosen.module == "scene/absorption");
    for (name, module) in [
        ("light_absorption", if absorbs { "scene/light_absorption" } else { "null/light_absorption" }),
        ("depth_limit", "step/light_depth"),
        ("medium_light", "step/medium_connection"),
        ("probe", "null/narrow_lobe"),
        ("aov_surface", "null/aov_surface"),
    ] {
        own.modules.entry(name).and_modify(|chosen| chosen.module = module);
    }
    own
}

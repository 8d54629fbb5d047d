//! What the plan decides for the directives of the shaders: which conditions hold, what the lists have, which modules and values are chosen,
//! each with the reason.

use std::collections::BTreeMap;

use super::state::{path_fields, places};
use super::{Bounces, QUEUES, UniformTables};
use crate::aov::{SeenSurface, Sum};
use crate::bitmap::FORMATS;
use crate::data::{FILM_SUMS, KIND_INSTANCE, KIND_TRIANGLE, RUN_LENGTH};
use crate::flatten::{BACKGROUNDS, BOUNDARIES, EVERY_FEATURE, Features, PRIMITIVES, TEXTURES};
use crate::gpu::link::{Choices, Chosen, Entry, Reason};
use crate::material::{DetailKind, Material};
use crate::options::{self, FeatureSet, Filter, Knob, RenderOptions};
use crate::shape::KINDS;

/// A struct with a member for each name that directives of one kind have in the shaders, so that none can be left undecided.
macro_rules! named {
    ($(#[$doc:meta])* $name:ident: $type:ty { $($(#[$about:meta])* $member:ident,)* }) => {
        $(#[$doc])*
        #[derive(Clone)]
        pub struct $name { $($(#[$about])* pub $member: $type,)* }

        impl $name {
            /// As the shaders write them.
            pub const NAMES: &[&str] = &[$(stringify!($member)),*];

            fn named(self) -> BTreeMap<&'static str, $type> {
                BTreeMap::from([$((stringify!($member), self.$member)),*])
            }
        }
    };
}

named! {
    /// What `//@ if` asks.
    Conditions: Option<Reason> {
        /// Rays are sent to lights.
        light,
        /// And by a kernel of their own.
        staged_light,
        medium,
        /// There is something to hit.
        surface,
        /// There is something that scatters: a surface or a medium.
        event,
        mesh,
        /// A mesh bounds a medium.
        mesh_boundary,
        /// Slots are sorted into queues,
        queue,
        /// and that as soon as it is known what rays meet: there are no media that may scatter them before.
        queue_of_hits,
        lens,
        /// Render space has the camera's axes.
        camera_axes,
        clamp,
        /// Samples have weights of either sign.
        signed,
        /// All primitives are asked of every ray.
        brute_force,
        gradient_background,
        image_background,
        several_backgrounds,
        /// Faces of meshes are sampled as lights.
        emitting_mesh,
        /// Primitives of any kind are.
        emitting_surface,
        /// And none of them scatters.
        emitting_without_scattering,
        /// Images of the scene have the first texture coordinates of meshes alone,
        one_uv_table,
        /// or tables of their own,
        uv_tables,
        /// and normal maps on smooth meshes have tangents in theirs.
        vertex_tangents,
        /// Some material of the scene has a number that may be that of an image, or none has.
        number_images,
        colour_images,
        /// The roughness of a material of the kernel varies over its surface,
        varying_roughness,
        /// or how metallic it is.
        varying_metallic,
        /// Some material emits beside what it scatters.
        glow,
        /// And it or another surface is sampled as a light.
        glow_of_light,
        /// A material of the kernel does,
        own_glow,
        /// and is sampled as a light,
        glow_is_sampled,
        /// Its light is among the direct light beside the image.
        glow_direct,
        /// A clear material of the kernel has a surface that lets a share of light pass alone,
        tinted,
        /// and lights are sampled or asked for;
        tinted_in_light,
        /// or it has an inside that absorbs.
        absorbing,
        /// A material of the kernel has a normal map, or none of them has one.
        normal_map,
        plain_normal,
        /// A material of the kernel has one, and lights are sampled.
        normal_map_in_light,
        /// A material of the kernel makes up for light that microfacets scatter more than once, or none of them does.
        multiscatter,
        single_scattering,
        /// The layer of a material of the kernel has a share or a colour of its own, or none has.
        own_layer,
        plain_layer,
        /// Paths have a sum: of light that is sampled, or of surfaces that emit and scatter.
        gathers,
        /// The colours of a mesh's vertices multiply that of a material of the kernel.
        vertex_colours,
        /// A material of the kernel has one of these: a number that varies, a glow, a normal map, or such colours;
        detailed,
        /// or none of them has.
        undetailed,
        /// Some material has an alpha,
        alpha,
        /// which that of a mesh's vertices multiplies,
        vertex_alpha,
        /// and some material that may have one is sampled as a light.
        alpha_of_light,
        emitting_sky,
        /// Lights without size are.
        delta_light,
        /// The sky or directional lights are, which stand beside those with a place.
        light_without_place,
        /// Something that emits is not sampled.
        unsampled,
        /// Lights are sampled, and narrow lobes hide some of their light, which probes count; or no lobe does.
        probed,
        unprobed,
        /// A material of the kernel is non-specular, and lights are sampled.
        surface_samples_light,
        /// A material of the kernel samples lights, or has a narrow lobe and probes them.
        sends_shadow_ray,
        /// One of them has two elements of the table.
        two_parts,
        /// One of them responds to light from both sides, on smooth meshes, where the two sides have points of their own.
        both_sides,
        /// One of them is a light that is sampled,
        met_light,
        /// The film has channels beside the radiance:
        aov,
        /// the albedo of the surface that is seen, its normal, one of them;
        aov_albedo,
        aov_normal,
        aov_surface,
        /// mirrors and clear glass are passed on the way to it, or not;
        aov_rough,
        aov_first,
        /// the depth of the first surface that camera rays hit, its position, which it is, one of them;
        aov_depth,
        aov_position,
        aov_object,
        aov_material,
        aov_hit,
        /// the number of rays that hit it, for the first two;
        aov_hits,
        /// the direct radiance.
        aov_direct,
    }
}

named! {
    /// What `//@ each` goes through.
    Lists: Vec<Entry> {
        /// The kinds of primitive but for the faces of meshes, which `mesh` is about: those need more than the others.
        primitive,
        /// The same of primitives that are sampled as lights.
        emitter,
        /// The same of boundaries of media.
        convex_boundary,
        /// The materials that the kernel serves.
        material,
        /// Those of them that are not specular.
        non_specular,
        /// Those of them that have two elements of the table.
        two_part,
        /// The non-specular ones that respond to light from both sides.
        both_sided,
        /// Those of all that are clear.
        clear,
        texture,
        /// The formats of the images' texels.
        texel_format,
        background,
        /// The last of them,
        own_background,
        /// and the ones before.
        other_background,
        path_plane,
        path_word,
        other_path_word,
    }
}

named! {
    /// The modules behind `choice/…`.
    Modules: Chosen {
        axes,
        camera,
        filter,
        colour,
        uv,
        shading,
        medium_albedo,
        roulette,
        probe,
        clamp,
        fresnel,
        offset,
        sphere_chord,
        light_choice,
        walk,
        sampler,
    }
}

named! {
    /// The numbers behind `${…}`.
    Values: u32 {
        stack_size,
        boundary_stack_size,
        media,
        sky_light,
        sky_columns,
        sky_rows,
        most_steps,
        run_length,
        queues,
        /// The queue that the kernel serves.
        queue,
        /// The sums of a pixel of the film, those of them beside the radiance's, and their places.
        film_sums,
        aov_sums,
        sum_of_albedo,
        sum_of_normal,
        sum_of_hits,
        sum_of_depth,
        sum_of_position,
        sum_of_object,
        sum_of_material,
        sum_of_direct,
    }
}

macro_rules! tables {
    ($($name:literal),*) => { [$(($name, concat!("space_of_", $name), concat!("size_of_", $name))),*] };
}
/// The tables but those of shapes by name, and the names of the values that say how each is bound.
const OTHER_TABLES: [(&str, &str, &str); 8] =
    tables!["nodes", "media", "lights", "delta_lights", "light_nodes", "materials", "textures", "frames"];

/// The same of all tables.
pub fn table_names() -> impl Iterator<Item = (&'static str, &'static str, &'static str)> {
    let of_shapes = KINDS.iter().map(|kind| (kind.table.name, kind.table.space, kind.table.size));
    OTHER_TABLES.into_iter().chain(of_shapes)
}

/// What a kernel is linked with.
pub(super) struct Decided {
    pub conditions: Conditions,
    lists: Lists,
    modules: Modules,
    values: Values,
}

impl Decided {
    pub fn choices(self, tables: &UniformTables) -> Choices {
        let table = |(name, space, size)| match tables.uniform.get(name) {
            Some(elements) => [(space, "uniform".to_string()), (size, format!(", {elements}"))],
            None => [(space, "storage, read".to_string()), (size, String::new())],
        };
        let numbers = self.values.named().into_iter().map(|(name, number)| (name, number.to_string()));
        Choices {
            conditions: self.conditions.named(),
            lists: self.lists.named(),
            modules: self.modules.named(),
            values: numbers.chain(table_names().flat_map(table)).collect(),
        }
    }
}

/// The first that asked.
fn first<'a>(used: impl IntoIterator<Item = &'a Option<String>>) -> Option<Reason> {
    used.into_iter().flatten().next().cloned().map(Reason::Asked)
}

fn asked(used: &Option<String>) -> Option<Reason> {
    first([used])
}

fn option(text: &str) -> Reason {
    Reason::Asked(text.to_string())
}

/// A module that nobody asks for by itself.
fn usual(module: &'static str) -> Chosen {
    Chosen { module, why: Reason::EveryRender }
}

/// One module where someone asked for it, else the usual one.
fn either(why: Option<Reason>, module: &'static str, other: &'static str) -> Chosen {
    why.map_or(usual(other), |why| Chosen { module, why })
}

/// The kinds that the scene uses, by the place of their names; the last one closes a switch over them.
pub(super) fn entries(names: &[&str], used: &[Option<String>]) -> Vec<Entry> {
    let kinds = (0..).zip(names).zip(used);
    closed(kinds.filter_map(|((number, name), used)| Some((*name, number, asked(used)?))))
}

fn closed<'a>(kinds: impl Iterator<Item = (&'a str, u32, Reason)>) -> Vec<Entry> {
    let entry = |(name, number, why): (&str, u32, _)| Entry { name: name.to_string(), number, closes: false, why };
    let mut entries: Vec<_> = kinds.map(entry).collect();
    if let Some(last) = entries.last_mut() {
        last.closes = true;
    }
    entries
}

/// Why there are meshes among these kinds, and the other kinds. Where there are, it is their lines that close a switch.
fn split_meshes(kinds: Vec<Entry>) -> (Option<Reason>, Vec<Entry>) {
    let (meshes, mut others): (Vec<_>, Vec<_>) =
        kinds.into_iter().partition(|kind| [KIND_TRIANGLE, KIND_INSTANCE].contains(&kind.number));
    others.iter_mut().for_each(|kind| kind.closes &= meshes.is_empty());
    (meshes.into_iter().next().map(|mesh| mesh.why), others)
}

/// Decides for a kernel that serves some of the scene's materials, and `queue` if they are sorted into queues.
pub(super) fn decide(
    features: &Features,
    options: &RenderOptions,
    materials: &[Entry],
    served: &[Entry],
    queue: u32,
    bounces: Bounces,
) -> Decided {
    let Bounces { fused, queues } = bounces;
    let if_so = |condition: bool, why: Reason| condition.then_some(why);
    let by_option = |knob: &Knob| Chosen { module: knob.module(options), why: option(&knob.asked(options)) };
    // What approximates, where the scene has what the option is about.
    let approximate = |knob: &Knob, in_scene: bool| match in_scene && !knob.is_default(options) {
        true => by_option(knob),
        false => usual(knob.module(&RenderOptions::default())),
    };
    let (mesh, primitive) = split_meshes(entries(PRIMITIVES, &features.primitives));
    let (emitting_mesh, emitter) = split_meshes(entries(PRIMITIVES, &features.emitters));
    let boundaries = BOUNDARIES.iter().zip(&features.boundaries);
    let boundaries = boundaries.filter_map(|((name, kind), used)| Some((*name, *kind, asked(used)?)));
    let (mesh_boundary, convex_boundary) = split_meshes(closed(boundaries));
    let texture = entries(TEXTURES, &features.textures);
    let texel_format = entries(FORMATS, &features.texel_formats);
    let background = entries(BACKGROUNDS, &features.backgrounds);
    let (own_background, other_background) = match background.split_last() {
        Some((own, others)) => (vec![own.clone()], others.to_vec()),
        None => (Vec::new(), Vec::new()),
    };

    let emitting_surface = first(&features.emitters);
    let emitting_sky = asked(&features.emitting_sky);
    let delta_light = asked(&features.delta_lights);
    // The lights that chance can find.
    let extended = emitting_surface.clone().or(emitting_sky.clone());
    let any_light = extended.clone().or(delta_light.clone()).unwrap_or(Reason::EveryRender);
    let light = if_so(features.lights > 0, any_light);
    let medium = if_so(features.crosses_media(), first(&features.boundaries).unwrap_or(Reason::EveryRender));
    let surface = materials.first().map(|kind| kind.why.clone());
    // A mesh makes walks long.
    let hit = mesh.clone().or(first(&features.primitives)).unwrap_or(Reason::EveryRender);
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
    // A specular lobe may hide lights with a size, and any other narrow lobe all lights.
    let any_narrow = first(&features.narrow).or(asked(&features.narrow_media));
    let hidden = any_narrow.or(extended.clone().and(first(&features.specular)));
    let probed = light.clone().and(hidden);
    let of_first = |used: &[Option<String>]| served_in(used).first().map(|kind| kind.why.clone());
    let sends_probe = probed.clone().and(of_first(&features.narrow).or(of_first(&features.specular)));
    let of_kind = |kind: &Entry| Material::KINDS.get(kind.number as usize);
    let two_part: Vec<Entry> =
        served.iter().filter(|kind| of_kind(kind).is_some_and(|kind| kind.has_second_part)).cloned().collect();
    let both_sided: Vec<Entry> =
        non_specular.iter().filter(|kind| of_kind(kind).is_some_and(|kind| kind.is_clear)).cloned().collect();
    let shines = served.iter().any(|kind| of_kind(kind).is_some_and(|kind| kind.emits));

    let event = surface.clone().or(medium.clone());
    let asked_aov = options::AOV.asked(options);
    let aov = |sums: &[Sum], there: &Option<Reason>| {
        let needed = there.is_some() && sums.iter().any(|sum| options.aov.needs(*sum));
        if_so(needed, option(&asked_aov))
    };
    let aov_surface = aov(&[Sum::Albedo, Sum::Normal], &event);
    let passes = options.aov.surface == SeenSurface::Rough;
    let place = |sum| options.aov.place(sum).unwrap_or(0) as u32;

    let glowing = &features.details[DetailKind::Emission as usize];
    let glow = first(glowing);
    let own = |detail: DetailKind| of_first(&features.details[detail as usize]);
    let (varying_roughness, varying_metallic) = (own(DetailKind::Roughness), own(DetailKind::Metallic));
    let (own_glow, normal_map) = (own(DetailKind::Emission), own(DetailKind::Normal));
    let multiscatter = own(DetailKind::Multiscatter);
    let own_layer = own(DetailKind::Specular);
    let (tinted, absorbing) = (of_first(&features.tinted), of_first(&features.absorbing));
    let glow_is_sampled = own_glow.clone().and(light.clone()).and(emitting_surface.clone());

    let vertex_colours = served_in(&features.details[DetailKind::VertexColours as usize]);
    let vertex_colours = vertex_colours.first().and_then(|kind| mesh.clone().and(Some(kind.why.clone())));
    let number_images = [DetailKind::Roughness, DetailKind::Metallic, DetailKind::Alpha]
        .into_iter()
        .find_map(|detail| first(&features.details[detail as usize]));
    let detailed = { [&varying_roughness, &varying_metallic, &own_glow, &normal_map, &vertex_colours, &own_layer] }
        .into_iter()
        .find_map(|detail| detail.clone());
    let alpha = surface.clone().and(first(&features.details[DetailKind::Alpha as usize]));

    let vertex_alpha = alpha.clone().and(mesh.clone()).and(first(&features.details[DetailKind::VertexAlpha as usize]));

    let uv_tables = mesh.clone().and(asked(&features.uv_tables));

    let both_sides = { both_sided.first().zip(light.as_ref()) }
        .and_then(|(kind, _)| asked(&features.smooth).and(Some(kind.why.clone())));
    let queue_why = if_so(queues, option(QUEUES));
    let conditions = Conditions {
        staged_light: light.clone().filter(|_| !fused),
        aov: if_so(!options.aov.is_empty(), option(&asked_aov)),
        aov_albedo: aov(&[Sum::Albedo], &event),
        aov_normal: aov(&[Sum::Normal], &event),
        aov_rough: aov_surface.clone().filter(|_| passes),
        aov_first: aov_surface.clone().filter(|_| !passes),
        aov_surface,
        aov_depth: aov(&[Sum::Depth], &surface),
        aov_position: aov(&[Sum::Position], &surface),
        aov_object: aov(&[Sum::Object], &surface),
        aov_material: aov(&[Sum::Material], &surface),
        aov_hit: aov(&[Sum::Hits, Sum::Object, Sum::Material], &surface),
        aov_hits: aov(&[Sum::Hits], &surface),
        aov_direct: aov(&[Sum::Direct], &Some(Reason::EveryRender)),
        event,
        queue_of_hits: queue_why.clone().filter(|_| medium.is_none()),
        queue: queue_why,
        lens: asked(&features.thin_lens),
        camera_axes: asked(&features.turned),
        clamp: if_so(
            options.clamp.is_some() && (surface.is_some() || features.media > 0),
            by_option(&options::CLAMP).why,
        ),
        signed: if_so(options.filter == Filter::Mitchell, by_option(&options::FILTER).why),
        gradient_background: asked(&features.backgrounds[1]),
        image_background: asked(&features.backgrounds[2]),
        several_backgrounds: if_so(!other_background.is_empty(), option(EVERY_FEATURE)),
        unsampled: match &features.unsampled {
            Some(left) => Some(option(&left.asked_by)),
            None => if_so(options.features == FeatureSet::All, option(EVERY_FEATURE)),
        },
        sends_shadow_ray: surface_samples_light.clone().or(sends_probe),
        two_parts: two_part.first().map(|kind| kind.why.clone()),
        both_sides,
        met_light: light.clone().and(emitting_surface.clone()).filter(|_| shines),
        emitting_without_scattering: emitting_surface.clone().filter(|_| glow.is_none()),
        undetailed: if_so(detailed.is_none(), Reason::EveryRender),
        detailed,
        vertex_colours,
        one_uv_table: if_so(uv_tables.is_none(), Reason::EveryRender),
        vertex_tangents: uv_tables.clone().and(asked(&features.vertex_tangents)),
        uv_tables,
        alpha_of_light: alpha.clone().and(glow.clone()).and(emitting_surface.clone()),
        alpha,
        vertex_alpha,
        glow_of_light: glow.clone().and(emitting_surface.clone()),
        gathers: light.clone().or(glow.clone()),
        glow_direct: own_glow.clone().and(aov(&[Sum::Direct], &Some(Reason::EveryRender))),
        colour_images: if_so(number_images.is_none(), Reason::EveryRender),
        number_images,
        varying_roughness,
        varying_metallic,
        glow_is_sampled,
        own_glow,
        glow,
        tinted_in_light: tinted.clone().and(surface_samples_light.clone()),
        tinted,
        absorbing,
        normal_map_in_light: normal_map.clone().and(surface_samples_light.clone()),
        plain_normal: if_so(normal_map.is_none(), Reason::EveryRender),
        normal_map,
        single_scattering: if_so(multiscatter.is_none(), Reason::EveryRender),
        plain_layer: if_so(own_layer.is_none(), Reason::EveryRender),
        own_layer,
        multiscatter,
        light_without_place: emitting_sky.clone().or(asked(&features.directional_lights)),
        delta_light,
        surface_samples_light,
        unprobed: if_so(probed.is_none(), Reason::EveryRender),
        probed,
        light,
        medium,
        surface,
        mesh,
        mesh_boundary,
        brute_force,
        emitting_mesh,
        emitting_surface,
        emitting_sky,
    };
    let has_glass = materials.iter().any(|kind| of_kind(kind).is_some_and(|kind| kind.is_clear));
    let has_spheres = primitive.iter().chain(&convex_boundary).any(|kind| kind.name == "sphere");
    let places = places(&path_fields(&conditions, fused));
    let numbered = |all: Vec<(&'static str, u32)>| {
        closed(all.into_iter().map(|(name, number)| (name, number, Reason::EveryRender)))
    };
    let image_texture = texture.iter().find(|kind| kind.name == "image").map(|kind| kind.why.clone());
    let modules = Modules {
        axes: either(asked(&features.turned), "scene/camera_axes", "scene/world_axes"),
        camera: either(asked(&features.thin_lens), "camera/thin_lens", "camera/pinhole"),
        filter: by_option(&options::FILTER),
        colour: either(first(&features.textures), "scene/textured_colour", "scene/plain_colour"),
        uv: either(image_texture, "scene/uv", "scene/no_uv"),
        shading: either(asked(&features.smooth), "scene/smooth_shading", "scene/flat_shading"),
        medium_albedo: either(asked(&features.textured_media), "scene/textured_medium", "scene/plain_medium"),
        light_choice: usual(if features.lights > 1 { "scene/light_tree" } else { "scene/one_light" }),
        walk,
        roulette: by_option(&options::ROULETTE),
        probe: either(conditions.probed.clone(), "step/narrow_lobe", "step/no_narrow_lobe"),
        clamp: approximate(&options::CLAMP, conditions.clamp.is_some()),
        fresnel: approximate(&options::FRESNEL, has_glass),
        offset: approximate(&options::OFFSET, conditions.surface.is_some()),
        sphere_chord: approximate(&options::PRECISION, has_spheres),
        sampler: by_option(&options::SAMPLER),
    };
    Decided {
        conditions,
        lists: Lists {
            primitive,
            emitter,
            convex_boundary,
            material: served.to_vec(),
            non_specular,
            two_part,
            both_sided,
            clear: { served.iter() }.filter(|kind| of_kind(kind).is_some_and(|kind| kind.is_clear)).cloned().collect(),
            texture,
            texel_format,
            background,
            own_background,
            other_background,
            path_plane: numbered(places.planes),
            path_word: numbered(places.words),
            other_path_word: numbered(places.others),
        },
        modules,
        values: Values {
            // No array has no elements.
            stack_size: features.stack_size + 1,
            boundary_stack_size: features.boundary_stack_size + 1,
            media: features.media,
            sky_light: features.sky_light,
            sky_columns: features.sky_grid.0,
            sky_rows: features.sky_grid.1,
            // Mesa 22.3 allows an invocation 65,535 iterations: for one walk, or for two, the other being a shadow ray's.
            most_steps: if features.shadow_rays { 19_000 } else { 48_000 },
            run_length: RUN_LENGTH,
            film_sums: (FILM_SUMS + options.aov.count()) as u32,
            aov_sums: options.aov.count() as u32,
            sum_of_albedo: place(Sum::Albedo),
            sum_of_normal: place(Sum::Normal),
            sum_of_hits: place(Sum::Hits),
            sum_of_depth: place(Sum::Depth),
            sum_of_position: place(Sum::Position),
            sum_of_object: place(Sum::Object),
            sum_of_material: place(Sum::Material),
            sum_of_direct: place(Sum::Direct),
            queues: materials.len() as u32,
            queue,
        },
    }
}

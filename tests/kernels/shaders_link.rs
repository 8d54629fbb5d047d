//! The shaders without a device: every combination of features links and validates, no file is unused, modules import
//! what their folders may, and the linker's errors name the location.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use gpu_rt::aov::{Aovs, SeenSurface};
use gpu_rt::bitmap::FORMATS;
use gpu_rt::data::{KIND_INSTANCE, KIND_TRIANGLE, Sampler};
use gpu_rt::flatten::{
    BACKGROUNDS, BOUNDARIES, DECLARED, Declared, FIELDS, Features, MATERIALS, PRIMITIVES, Quantities, TEXTURES,
};
use gpu_rt::gpu::layout::BindingKind;
use gpu_rt::gpu::link::{Choices, Embedded, Entry, Heads, Library, Linked, Reason, When, link};
use gpu_rt::lobe::rows;
use gpu_rt::material::{LobeWidth, Material, MaterialKind, ROUGH_LAYER};
use gpu_rt::options::{
    FeatureSet, Filter, Fresnel, LightPaths, Precision, RenderOptions, Scatter, Switch, TRADE_OFFS, Walk,
};
use gpu_rt::plan::{CONDITIONS, Kernel, Kernels, UniformTables, choices_of};

use crate::common::referee::{differences, hashes};

/// The extensions of glTF's material that are lobes, or change those that it has.
const LOBES_OF_PBR: [&[&str]; 12] = [
    &["specular_share"],
    &["transmission"],
    &["coat"],
    &["coat", "coat_roughness", "coat_normal"],
    &["coat", "coat_normal", "emission"],
    &["sheen"],
    &["sheen", "sheen_roughness", "coat", "transmission"],
    &["specular", "iridescence"],
    &["specular", "iridescence", "iridescence_thickness", "transmission", "dispersion"],
    &["diffuse_transmission"],
    &["diffuse_transmission", "diffuse_transmission_share", "coat"],
    &["transmission", "dispersion"],
];

/// Numbers of backgrounds.
const SOLID: usize = 0;
const IMAGE: usize = 2;

/// Adds the facts of a group whose bits are on, as far as these kinds can have it.
fn with<T: AsRef<str>>(mut features: Features, group: &str, kinds: &[T], bits: usize) -> Features {
    let possible = &Declared::of(group).expect(group).kinds;
    let on = kinds.iter().enumerate().filter(|(i, _)| bits >> i & 1 == 1).map(|(_, kind)| kind.as_ref());
    for kind in on.filter(|kind| possible.contains(kind)) {
        features.require(format!("{group}.{kind}"), || "a test".to_string());
    }
    features
}

/// Adds single facts.
fn having(mut features: Features, facts: &[&str]) -> Features {
    facts.iter().for_each(|fact| features.require(*fact, || "a test".to_string()));
    features
}

fn quantified(mut features: Features, change: impl FnOnce(&mut Quantities)) -> Features {
    change(&mut features.quantities);
    features
}

/// The bits of the kinds of a group that are there.
fn bits_in<T: AsRef<str>>(features: &Features, group: &str, kinds: &[T]) -> usize {
    let has = |kind: &T| features.reason(&format!("{group}.{}", kind.as_ref())).is_some();
    kinds.iter().enumerate().filter(|(_, kind)| has(kind)).map(|(i, _)| 1 << i).sum()
}

fn boundaries() -> Vec<&'static str> {
    BOUNDARIES.iter().map(|(name, _)| *name).collect()
}

/// Features by the bits of the kinds that are on.
fn features(primitives: usize, materials: usize, textures: usize, background: usize, thin_lens: bool) -> Features {
    let has_image = background >= IMAGE
        || TEXTURES.iter().position(|name| *name == "image").is_some_and(|i| textures >> i & 1 == 1);
    let lobe = |width: LobeWidth| materials & bits_of(|kind| kind.widths.contains(&width));
    let mut found = quantified(Features::default(), |own| own.stack_size = 8);
    for (group, kinds, bits) in [
        ("texel", FORMATS, if has_image { all(FORMATS) } else { 0 }),
        ("shape", PRIMITIVES, primitives),
        ("material", MATERIALS, materials),
        ("wide_lobe", MATERIALS, lobe(LobeWidth::Wide)),
        ("specular_lobe", MATERIALS, lobe(LobeWidth::Specular)),
        ("narrow_lobe", MATERIALS, lobe(LobeWidth::Narrow)),
        ("texture", TEXTURES, textures),
        ("background", BACKGROUNDS, 1 << background),
    ] {
        found = with(found, group, kinds, bits);
    }
    having(found, if thin_lens { &["lens"] } else { &[] })
}

/// The bits of some kinds of material.
fn bits_of(wanted: impl Fn(&MaterialKind) -> bool) -> usize {
    (0..).zip(Material::KINDS).filter(|(_, kind)| wanted(kind)).map(|(i, _)| 1 << i).sum()
}

/// Whether materials of the kind can answer to lights.
fn spreads(kind: &MaterialKind) -> bool {
    kind.widths.contains(&LobeWidth::Wide)
}

fn kind_of(shader: &str) -> &'static MaterialKind {
    Material::KINDS.iter().find(|kind| kind.shader == shader).expect("there is such a material")
}

/// Adds media in these boundaries.
fn with_media(features: Features, bits: usize, textured_media: bool) -> Features {
    let found = having(
        with(features, "boundary", &boundaries(), bits),
        if textured_media { &["textured_medium"] } else { &[] },
    );
    quantified(found, |own| (own.media, own.boundary_stack_size) = (bits.count_ones() + 1, 8))
}

/// Whether anything answers to lights.
fn answers(features: &Features) -> bool {
    features.quantities.media > 0 || features.any("wide_lobe").is_some()
}

/// Adds these emitters sampled as lights where anything answers to them.
fn lit(features: Features, emitters: usize, sky: bool) -> Features {
    if !answers(&features) {
        return features;
    }
    let mut found = with(features, "area_light", PRIMITIVES, emitters);
    found = having(found, if emitters % 2 == 1 { &["textured_light"] } else { &[] });
    found = having(found, if sky { &["sky_light"] } else { &[] });
    let count = emitters.count_ones();
    quantified(found, |own| {
        (own.shadow_rays, own.lights, own.sky_grid, own.sky_light) = (true, count + u32::from(sky), (4, 2), count);
    })
}

/// Adds an emission to the materials that scatter.
fn emissive(features: Features) -> Features {
    with_extension(features, "emission")
}

/// Adds an extension to all materials that may scatter into many directions.
fn with_extension(features: Features, name: &str) -> Features {
    let wide = bits_in(&features, "wide_lobe", MATERIALS);
    with(features, name, MATERIALS, wide)
}

/// Adds an alpha to materials, and colours and alphas of vertices, also for what they emit.
fn covered(features: Features) -> Features {
    let of_vertices = ["vertex_colours", "vertex_alpha", "vertex_emission"];
    of_vertices.into_iter().fold(with_extension(features, "alpha"), with_extension)
}

/// Whether materials of a kind may have a row of this name.
fn can_have(kind: &MaterialKind, row: &str) -> bool {
    rows().any(|known| known.name == row && kind.can_have(known))
}

/// Adds numbers of materials that vary, those of images among them.
fn varying(features: Features, kinds: &[&str]) -> Features {
    let has_images = features.reason("texture.image").is_some();
    let features = having(features, if has_images { &["number_images"] } else { &[] });
    let materials = bits_in(&features, "material", MATERIALS);
    let of_kind = |kind: &&str| materials & bits_of(|own| can_have(own, kind));
    kinds.iter().fold(features, |features, kind| with(features, kind, MATERIALS, of_kind(kind)))
}

/// Adds colours to the clear materials.
fn coloured(features: Features, tinted: bool, absorbing: bool) -> Features {
    let clear = bits_in(&features, "material", MATERIALS) & bits_of(|kind| kind.is_transmissive);
    let found = with(features, "tinted", MATERIALS, if tinted { clear } else { 0 });
    with(found, "absorbing", MATERIALS, if absorbing { clear } else { 0 })
}

/// Makes some kinds of primitive smooth panes.
fn paned(features: Features, shapes: usize) -> Features {
    let pane_textures = features.any("texture").is_some();
    let found = with(features, "smooth_pane", PRIMITIVES, shapes);
    quantified(having(found, if pane_textures { &["textured_pane"] } else { &[] }), |own| {
        own.pane_textures = pane_textures
    })
}

/// Adds lights without size, directional ones among them, where anything answers to them.
fn delta_lit(features: Features, directional: bool) -> Features {
    if !answers(&features) {
        return features;
    }
    let found = having(features, if directional { &["delta_light", "directional_light"] } else { &["delta_light"] });
    quantified(found, |own| (own.shadow_rays, own.lights) = (true, own.lights + 1))
}

/// Gives bodies of these shapes an alpha.
fn holed(features: Features, shapes: usize) -> Features {
    with(features, "body_with_alpha", PRIMITIVES, shapes)
}

/// Cuts the lights of these shapes into parts, and samples bodies with an alpha on both sides.
fn parted(features: Features, shapes: usize) -> Features {
    let has_parts = (0..).zip(PRIMITIVES).filter(|(_, name)| ["quad", "triangle", "disk"].contains(*name));
    let bodies = (0..).zip(PRIMITIVES).filter(|(_, name)| boundaries().contains(*name));
    let bits = |those: &mut dyn Iterator<Item = usize>| those.map(|i| 1 << i).sum::<usize>() & shapes;
    let crosses = features.any("body_with_alpha").is_some() && bits(&mut bodies.map(|(i, _)| i)) > 0;
    let found = with(features, "parted", PRIMITIVES, bits(&mut has_parts.map(|(i, _)| i)));
    having(found, if crosses { &["crossed_light"] } else { &[] })
}

/// Has so many lights that one is chosen by the tree.
fn many_lights(features: Features) -> Features {
    quantified(features, |own| (own.lights, own.sky_light) = (2, 1))
}

/// Adds images on meshes that have tables of their own, and tangents in them.
fn with_tables(features: Features, tangents: bool) -> Features {
    having(features, if tangents { &["uv_tables", "vertex_tangents"] } else { &["uv_tables"] })
}

/// Adds smooth meshes.
fn smooth(features: Features) -> Features {
    having(features, &["smooth"])
}

fn all<T>(names: &[T]) -> usize {
    (1 << names.len()) - 1
}

fn everything() -> Features {
    having(all_sampled(), &["not_sampled"])
}

fn all_sampled() -> Features {
    let surfaces = features(all(PRIMITIVES), all(MATERIALS), all(TEXTURES), IMAGE, true);
    let rows = "roughness metallic multiscatter one_sided inner_reflections beckmann rough_layer specular specular_share transmission coat coat_roughness coat_normal \
                sheen sheen_roughness anisotropy iridescence iridescence_thickness diffuse_transmission diffuse_transmission_share dispersion";
    let surfaces = varying(surfaces, &rows.split(' ').collect::<Vec<_>>());
    let lit = delta_lit(lit(with_media(smooth(surfaces), all(&BOUNDARIES), true), all(PRIMITIVES), true), true);
    with_extension(covered(emissive(coloured(lit, true, true))), "normal")
}

/// Turns render space to the camera's axes.
fn turned(features: Features) -> Features {
    having(features, &["camera_axes"])
}

/// Everything that it has moves; the camera too, if `camera` does.
fn moving(features: Features, camera: bool) -> Features {
    let boundary = |name: &str| {
        let number = PRIMITIVES.iter().position(|own| *own == name).expect("it is a shape") as u32;
        let code = if number == KIND_TRIANGLE { KIND_INSTANCE } else { number };
        BOUNDARIES.iter().any(|(own, kind)| *kind == code && features.reason(&format!("boundary.{own}")).is_some())
    };
    let boundaries = (0..).zip(PRIMITIVES).filter(|(_, name)| boundary(name)).map(|(i, _)| 1 << i).sum();
    let shapes = bits_in(&features, "shape", PRIMITIVES);
    let lights = features.reason("delta_light").is_some();
    let media = features.reason("textured_medium").is_some() || features.any("varying").is_some();
    let own = [(lights, "moving_light"), (media, "moving_medium"), (camera, "moving_camera")];
    let own: Vec<&str> = own.into_iter().filter(|(moves, _)| *moves).map(|(_, fact)| fact).collect();
    let found = with(with(features, "moves", PRIMITIVES, shapes), "boundary_moves", PRIMITIVES, boundaries);
    quantified(having(found, &own), |own| own.motion_iterations = 3)
}

/// Has so few primitives that each ray tests all of them.
fn few(features: Features) -> Features {
    quantified(features, |own| own.brute_force = true)
}

/// The defaults with one of the options that approximate, by its number.
fn approximate(number: usize) -> RenderOptions {
    let mut options = RenderOptions::default();
    match number {
        0 => options.fresnel = Fresnel::Schlick,
        1 => options.clamp = Some(1.0),
        _ => options.precision = Precision::Fast,
    }
    options
}

/// The defaults with all of them, and without roulette and Sobol points.
fn approximate_all() -> RenderOptions {
    RenderOptions {
        fresnel: Fresnel::Schlick,
        clamp: Some(1.0),
        precision: Precision::Fast,
        roulette: Switch::Off,
        sampler: Sampler::Independent,
        ..RenderOptions::default()
    }
}

/// Every set of primitives and of textures, every pair of materials and all of them, every background and lens, each beside the least of the others;
/// primitives with textures, which one kernel joins; nothing, and everything.
fn combinations() -> Vec<(Features, RenderOptions)> {
    let mut found = vec![features(0, 0, 0, SOLID, false), everything()];
    let (primitives, materials, textures) = (all(PRIMITIVES), all(MATERIALS), all(TEXTURES));
    // A shape's code is in switches over the kinds of shape: each alone, in pairs, and all of them.
    let shapes: Vec<usize> = (1..=primitives).filter(|set| set.count_ones() <= 2 || *set == primitives).collect();
    found.extend(shapes.iter().map(|set| features(*set, 1, 0, SOLID, false)));
    // Without meshes, which have a hierarchy of their own.
    for set in 1..1 << KIND_TRIANGLE {
        let surfaces = few(features(set, 1, 0, SOLID, false));
        found.extend([lit(surfaces.clone(), set, false), surfaces]);
    }
    found.push(few(lit(with_media(features(7, materials, 0, SOLID, false), 1, false), 7, false)));
    // A mix has parts.
    let mix = bits_of(|kind| !kind.has_functions());
    let pairs = (1..=materials).filter(|set| *set != mix && (set.count_ones() <= 2 || *set == materials));
    let pairs: Vec<usize> = pairs.collect();
    found.extend(pairs.iter().map(|set| features(1, *set, 0, SOLID, false)));
    for (set, textures) in [(3 | mix, 0), (materials, textures)] {
        let mixed = with(features(1, set, textures, SOLID, false), "mix", MATERIALS, mix);
        found.extend([mixed.clone(), lit(mixed.clone(), 1, false), lit(with(mixed, "alpha", MATERIALS, mix), 1, true)]);
    }
    found.extend((0..=textures).map(|set| features(1, 1, set, SOLID, false)));
    // Images of every format, on surfaces and in the sky.
    for formats in (0..FORMATS.len()).map(|i| 1 << i) {
        let only = |of: Features| {
            FORMATS.iter().fold(of, |mut of, format| {
                of.forget(&format!("texel.{format}"));
                of
            })
        };
        let images = |of: Features| with(only(of), "texel", FORMATS, formats);
        found.extend([images(features(1, 1, textures, SOLID, false)), images(features(1, 1, 0, IMAGE, false))]);
    }
    for background in 0..BACKGROUNDS.len() {
        found.extend([false, true].map(|lens| features(1, 1, 0, background, lens)));
        found.push(features(0, 0, 0, background, true));
        found.push(turned(features(1, 1, 0, background, false)));
    }
    for primitive in 0..PRIMITIVES.len() {
        for texture in 0..TEXTURES.len() {
            found.push(features(1 << primitive, 1, 1 << texture, IMAGE, false));
        }
    }
    // Media in every set of boundaries, without anything else to hit, and beside each primitive.
    for boundaries in 1..=all(&BOUNDARIES) {
        found.push(with_media(features(0, 0, 0, SOLID, false), boundaries, false));
        found
            .extend((0..PRIMITIVES.len()).map(|i| with_media(features(1 << i, 3, 0, SOLID, false), boundaries, false)));
    }
    found.extend((0..TEXTURES.len()).map(|i| with_media(features(0, 0, 1 << i, SOLID, false), 1, true)));
    // Nothing to hit before every background, with media and without, under a sky that is sampled.
    for background in 0..BACKGROUNDS.len() {
        for turn in [false, true] {
            let nothing = features(0, 0, 0, background, false);
            let nothing = if turn { turned(nothing) } else { nothing };
            found.extend((1..=all(&BOUNDARIES)).map(|boundaries| with_media(nothing.clone(), boundaries, false)));
            if background >= IMAGE {
                let media = (1..=all(&BOUNDARIES)).map(|boundaries| with_media(nothing.clone(), boundaries, false));
                found.extend(media.map(|media| lit(media, 0, true)));
            }
            found.push(nothing);
        }
    }
    for set in shapes.iter().copied() {
        if set >> KIND_TRIANGLE & 1 == 1 {
            found.push(smooth(features(set, materials, 0, SOLID, false)));
        }
    }
    // Every kind of light, beside every set of materials and in media.
    for emitters in [0].into_iter().chain(shapes.iter().copied()) {
        let surfaces = features(emitters.max(1), materials, 0, IMAGE, false);
        found.extend([lit(surfaces.clone(), emitters, true), lit(surfaces.clone(), emitters.max(1), false)]);
        found.push(lit(with_media(surfaces, 1 + emitters % all(&BOUNDARIES), false), emitters.max(1), false));
    }
    // Numbers that vary, of one kind of material and of all, with each of them alone.
    for kind in ["roughness", "metallic"] {
        for set in (0..MATERIALS.len()).filter(|i| can_have(&Material::KINDS[*i], kind)).map(|i| 1 << i) {
            found.push(lit(varying(features(1, set, textures, SOLID, false), &[kind]), 1, false));
        }
        found.push(varying(features(1, materials, textures, SOLID, false), &[kind]));
    }
    // Densities that vary, in every set of boundaries, with and without light, emission, temperatures and motion.
    for fields in 1..=all(FIELDS) {
        for boundaries in 1..=all(&BOUNDARIES) {
            let fog = with_media(features(1, 1, 0, SOLID, false), boundaries, false);
            let fog = with(fog, "varying", FIELDS, fields);
            let glowing = having(lit(fog.clone(), 1, false), &["medium_emission"]);
            let fire = having(glowing.clone(), &["blackbody"]);
            found.extend([fog.clone(), lit(fog.clone(), 1, true), moving(fire.clone(), false), glowing, fire]);
        }
    }
    found.push(having(with_media(features(0, 0, 0, SOLID, false), 1, false), &["medium_emission"]));
    let of_all = having(everything(), &["medium_emission", "blackbody"]);
    found.push(with(of_all, "varying", FIELDS, all(FIELDS)));
    // Surfaces that emit and scatter: by chance alone, sampled, and beside other lights.
    for set in [1, materials] {
        let own = emissive(features(1, set, 0, SOLID, false));
        found.extend([own.clone(), lit(own.clone(), 1, false), lit(own.clone(), 1, true), lit(own, 0, true)]);
    }
    for emitters in (0..PRIMITIVES.len()).map(|i| 1 << i) {
        found.push(lit(with_media(emissive(features(emitters, 1, 0, SOLID, false)), 1, false), emitters, false));
    }
    // Surfaces with an alpha: of each kind, sampled as lights and beside them, with textures and in media.
    for set in (0..PRIMITIVES.len()).map(|i| 1 << i) {
        let own = covered(features(set, 1, 0, SOLID, false));
        let bodies = holed(lit(emissive(own.clone()), set, false), set);
        found.extend([parted(bodies.clone(), set), parted(many_lights(bodies), set)]);
        found.extend([
            own.clone(),
            emissive(own.clone()),
            lit(emissive(own.clone()), set, false),
            delta_lit(own.clone(), true),
            with_extension(features(set, 1, 0, SOLID, false), "alpha"),
        ]);
        found.push(lit(with_media(covered(features(set, 1, textures, IMAGE, false)), 1, false), set, true));
    }
    // Normal maps on each shape, in every material, with and without light.
    for (shapes, set) in (0..PRIMITIVES.len()).map(|i| (1 << i, 1)).chain([(primitives, materials)]) {
        let mapped = with_extension(features(shapes, set, textures, SOLID, false), "normal");
        found.extend([mapped.clone(), lit(mapped.clone(), shapes, false), lit(mapped.clone(), 0, true)]);
        if shapes == primitives {
            found.push(smooth(mapped));
        }
    }
    // Images on meshes with tables of their own: colours alone, and normal maps on flat and on smooth meshes.
    for textures in (0..TEXTURES.len()).map(|i| 1 << i).chain([textures]) {
        for (shapes, set) in [(1 << KIND_TRIANGLE, 1), (primitives, materials)] {
            let own = with_tables(features(shapes, set, textures, SOLID, false), false);
            let mapped = with_extension(own.clone(), "normal");
            found.extend([own, lit(mapped.clone(), shapes, false), smooth(with_tables(mapped, true))]);
        }
    }
    // Light that microfacets scatter more than once: each material alone, and all.
    for set in [bits_of(|kind| can_have(kind, "multiscatter")), materials] {
        let full = varying(features(1, set, 0, SOLID, false), &["multiscatter"]);
        found.extend([full.clone(), lit(full.clone(), 1, false), lit(with_extension(full, "normal"), 0, true)]);
    }
    // Beckmann's microfacets, and rough layers.
    for row in ["beckmann", "rough_layer"] {
        for set in [bits_of(|kind| can_have(kind, row)), materials] {
            let own = varying(features(1, set, 0, SOLID, false), &[row]);
            found.extend([own.clone(), lit(own.clone(), 1, false), lit(varying(own, &["anisotropy"]), 0, true)]);
        }
    }
    // Layers of their own: alone, and with all materials.
    for set in [bits_of(|kind| can_have(kind, "specular")), materials] {
        let layered = varying(features(1, set, 0, SOLID, false), &["specular"]);
        let both = varying(layered.clone(), &["multiscatter"]);
        found.extend([layered.clone(), lit(layered, 1, false), lit(both, 0, true)]);
    }
    // What glTF's material has around its base: each alone, and with all materials.
    for kinds in LOBES_OF_PBR {
        for set in [bits_of(|own| can_have(own, "coat")), materials] {
            let own = varying(features(1 << KIND_TRIANGLE, set, 0, SOLID, false), kinds);
            found.extend([own.clone(), lit(smooth(own.clone()), 1 << KIND_TRIANGLE, false), lit(own, 0, true)]);
            let ball = varying(features(1, set, textures, SOLID, false), kinds);
            found.extend([lit(ball.clone(), 1, false), lit(ball, 0, true)]);
        }
    }
    // Anisotropic microfacets on each shape, flat and smooth meshes: of each material that may have them, and of all.
    for shapes in (0..PRIMITIVES.len()).map(|i| 1 << i).chain([primitives]) {
        for set in [bits_of(|own| own.shader == "conductor"), materials] {
            let own = varying(features(shapes, set, textures, SOLID, false), &["anisotropy"]);
            found.extend([own.clone(), lit(own.clone(), shapes, false)]);
            if shapes >> KIND_TRIANGLE & 1 == 1 {
                found.push(lit(smooth(with_tables(own, true)), 0, true));
            }
        }
    }
    // Coloured glass, smooth and rough, alone and beside the other materials.
    for set in [bits_of(|kind| kind.is_transmissive), materials] {
        for (tinted, absorbing) in [(true, false), (false, true), (true, true)] {
            let glass = coloured(features(1, set, 0, SOLID, false), tinted, absorbing);
            let dispersed = varying(glass.clone(), &["dispersion"]);
            for glass in [glass, dispersed] {
                found.extend([glass.clone(), lit(glass.clone(), 1, false), lit(glass, 0, true)]);
            }
        }
    }
    // Smooth panes of each shape: alone, with all materials, textures and an alpha, in media, and under lights.
    let pane = bits_of(|kind| kind.is_pane);
    for set in (0..PRIMITIVES.len()).map(|i| 1 << i).chain([primitives]) {
        let alone = paned(features(set, pane, 0, SOLID, false), set);
        let full = paned(covered(features(set, materials, textures, IMAGE, false)), set);
        let holes = holed(covered(lit(features(set, materials, textures, IMAGE, false), set, true)), set);
        found.extend([parted(holes.clone(), set), holes.clone(), paned(holes, set)]);
        let mapped = paned(with_extension(features(set, pane, textures, SOLID, false), "normal"), set);
        if set != primitives {
            let beside = paned(features(set, materials, 0, SOLID, false), set);
            found.extend([few(alone.clone()), delta_lit(few(beside), true)]);
        }
        found.extend([lit(full.clone(), set, true), lit(with_media(full, all(&BOUNDARIES), false), set, false)]);
        found.extend([with_media(alone.clone(), 1, false), alone, mapped]);
    }
    // Lights without size alone, with every material and in media, and beside each kind of light.
    for directional in [false, true] {
        let alone = |surfaces: Features| delta_lit(surfaces, directional);
        found.extend(pairs.iter().map(|set| alone(features(1, *set, 0, SOLID, false))));
        let several = pairs.iter().map(|set| alone(features(1, *set, 0, SOLID, false)));
        found.extend(several.filter(|features| features.quantities.lights > 0).map(many_lights));
        found.push(alone(with_media(features(0, 0, 0, SOLID, false), 1, false)));
        found.push(few(alone(features(1, 1, 0, SOLID, false))));
        for emitters in (0..PRIMITIVES.len()).map(|i| 1 << i) {
            let surfaces = features(emitters, materials, 0, IMAGE, false);
            found.extend([false, true].map(|sky| many_lights(alone(lit(surfaces.clone(), emitters, sky)))));
        }
    }
    found.extend(pairs.iter().map(|set| lit(features(1, *set, 0, SOLID, false), 1, false)));
    for sky in [false, true] {
        let of_each = shapes.iter().map(|set| lit(features(*set, 1, 0, IMAGE, false), *set, sky));
        found.extend(of_each.map(many_lights));
    }
    found.extend([many_lights(everything()), turned(everything())]);
    // Each shape moves, alone, as a light, with an alpha, a normal map, or a pane; boundaries of media do, and the camera alone.
    for set in (0..PRIMITIVES.len()).map(|i| 1 << i) {
        let own = features(set, 1, textures, SOLID, false);
        let panes = paned(features(set, materials, 0, SOLID, true), set);
        let all = [own.clone(), lit(own.clone(), set, false), covered(own.clone()), panes];
        found.extend(all.map(|features| moving(features, set > 1)));
        found.push(moving(lit(with_extension(own, "normal"), set, true), false));
    }
    for boundaries in 1..=all(&BOUNDARIES) {
        found.push(moving(with_media(features(0, 0, 1, SOLID, false), boundaries, true), false));
    }
    let still = features(1, 1, 0, SOLID, true);
    found.push(having(still, &["moving_camera"]));
    found.extend([false, true].map(|camera| moving(many_lights(everything()), camera)));
    let mut found: Vec<_> = found.into_iter().map(|features| (features, RenderOptions::default())).collect();
    // What approximates: each beside the least and everything, with lights and without; all of it beside every kind.
    for number in 0..3 {
        let (spheres, media) = (features(1, materials, 0, SOLID, false), features(0, 0, 0, SOLID, false));
        let beside = [spheres.clone(), lit(spheres, 1, false), with_media(media, 1, false), everything()];
        found.extend(beside.map(|features| (features, approximate(number))));
    }
    let mut beside: Vec<_> =
        shapes.iter().map(|set| lit(features(*set, materials, 0, IMAGE, false), *set, true)).collect();
    beside.extend(pairs.iter().map(|set| features(1, *set, 0, SOLID, false)));
    beside.extend((1..=all(&BOUNDARIES)).map(|set| with_media(features(1, 1, 0, SOLID, false), set, false)));
    beside.extend([everything(), many_lights(everything())]);
    found.extend(beside.into_iter().map(|features| (features, approximate_all())));
    // Every filter, beside the least and everything.
    for filter in [Filter::Tent, Filter::Gauss, Filter::Mitchell] {
        let beside = [features(0, 0, 0, SOLID, true), everything()];
        found.extend(beside.map(|features| (features, RenderOptions { filter, ..RenderOptions::default() })));
    }
    // Light paths: beside each kind of light, all materials and media, with each filter, and with everything.
    let traced = |features| quantified(having(features, &["light_paths"]), |own| own.aims = 3);
    for (number, emitters) in (0..PRIMITIVES.len()).map(|i| 1 << i).chain([primitives]).enumerate() {
        let surfaces = features(emitters, materials, textures, SOLID, number % 2 == 1);
        let glass = parted(coloured(lit(surfaces, emitters, false), true, number % 2 == 0), emitters);
        let filter = [Filter::Box, Filter::Tent, Filter::Gauss, Filter::Mitchell][number % 4];
        let options = RenderOptions { filter, light_paths: LightPaths::Count(8), ..RenderOptions::default() };
        let fog = delta_lit(with_media(glass.clone(), 1, number % 2 == 0), true);
        found.extend([glass, fog, everything()].map(|features| (traced(features), options.clone())));
    }
    // Each projection: beside the least, a moving camera and everything, without light paths and with them.
    for projection in ["orthographic", "equirectangular", "fisheye", "calibrated", "calibrated_fisheye"] {
        let glass = lit(features(1, materials, 0, SOLID, false), 1, false);
        let moves = having(glass.clone(), &["moving_camera"]);
        for (surfaces, is_traced) in
            [(glass.clone(), false), (moves, true), (everything(), false), (everything(), true)]
        {
            let found_by = having(surfaces, &[&format!("projection.{projection}")]);
            let light_paths = if is_traced { LightPaths::Count(8) } else { LightPaths::Off };
            let own = if is_traced { traced(found_by) } else { found_by };
            found.push((own, RenderOptions { light_paths, ..RenderOptions::default() }));
        }
    }
    // Every channel beside the radiance, by itself and with the others, beside nothing, media, a sphere and everything.
    let names = ["albedo", "normal", "depth", "position", "object", "material", "direct", "indirect", "lights"];
    let every = names.join(",");
    for list in names.into_iter().chain([every.as_str()]) {
        for (surface, filter) in [(SeenSurface::Rough, Filter::Box), (SeenSurface::First, Filter::Mitchell)] {
            let mut options = RenderOptions { filter, ..RenderOptions::default() };
            options.aov.set(Aovs::parse(list).expect("they are names"));
            options.aov.surface = surface;
            options.aov = options.aov.of_groups(&["background", "key"].map(str::to_owned));
            let nothing = features(0, 0, 0, SOLID, false);
            let fog = with_media(nothing.clone(), 1, false);
            let beside = [nothing, fog, features(1, materials, 0, SOLID, true), everything()];
            found.extend(beside.map(|features| (features, options.clone())));
            let glass = lit(features(1, materials, 0, SOLID, false), 1, false);
            found.push((traced(glass), RenderOptions { light_paths: LightPaths::Count(8), ..options }));
        }
    }
    // `--features all`.
    let all_backgrounds = with(turned(everything()), "background", BACKGROUNDS, all(BACKGROUNDS));
    found.push((all_backgrounds, RenderOptions { features: FeatureSet::All, ..RenderOptions::default() }));
    // Every channel of sample 0, by itself and with the others.
    let names = ["motion", "depth0", "distance0", "position0", "normal0", "uv0", "face0", "offset0"];
    let every = names.join(",");
    for list in names.into_iter().chain([every.as_str()]) {
        let mut options = RenderOptions::default();
        options.aov.set(Aovs::parse(list).expect("they are names"));
        let sphere = features(1, materials, 0, SOLID, true);
        let moves = having(sphere.clone(), &["moving_camera"]);
        let beside = [features(0, 0, 0, SOLID, false), sphere, moves, everything()];
        found.extend(beside.map(|features| (features, options.clone())));
    }
    let beam = having(delta_lit(features(1, 1, 0, SOLID, false), false), &["falloff"]);
    found.push((beam, RenderOptions::default()));
    let mesh = having(features(1 << KIND_TRIANGLE, 1, all(TEXTURES), SOLID, false), &["image_wrap"]);
    let mapped = with_extension(with_tables(mesh.clone(), true), "normal");
    let placed = having(features(1, 1, 0, SOLID, false), &["placed"]);
    found.extend([mesh, mapped, placed].map(|features| (features, RenderOptions::default())));
    // Meshes with siblings beside each other: alone, around a medium, and with everything.
    let around = with_media(features(0, 0, 0, SOLID, false), all(&BOUNDARIES), false);
    let beside = [features(1 << KIND_TRIANGLE, 1, 0, SOLID, false), around, everything()];
    let siblings = RenderOptions { walk: Walk::Siblings, ..RenderOptions::default() };
    found.extend(beside.map(|features| (features, siblings.clone())));
    // Mattes, alone, with assets and with other channels.
    for list in ["cryptomatte", "cryptomatte,cryptoasset,object,albedo,depth0"] {
        let mut options = RenderOptions::default();
        options.aov.set(Aovs::parse(list).expect("they are names"));
        let fog = with_media(features(0, 0, 0, SOLID, false), 1, false);
        let beside = [fog, features(1, materials, 0, SOLID, true), everything()];
        found.extend(beside.map(|features| (features, options.clone())));
    }
    found
}

fn kernels(features: &Features, options: &RenderOptions, scatter: Scatter) -> Kernels {
    Kernels::link(features, options, scatter, &UniformTables::default())
        .unwrap_or_else(|error| panic!("{features:?}, {options:?}, {scatter:?}: {error}"))
}

/// The fused kernel of each combination has the lines of all of its stages; with queues two of five are linked here, and stage by stage one.
/// (Every scene of the lattice is linked in each way by `features::nothing_that_is_linked_is_out_of_reach`.)
#[test]
fn every_combination_of_features_is_valid_and_leaves_no_line_unused() {
    let rows = each_combination_is_valid(&|number| match number % 5 {
        0 | 2 => &[Scatter::Fused, Scatter::Queues],
        4 => &[Scatter::Fused, Scatter::Linked],
        _ => &[Scatter::Fused],
    });
    let changed = differences("kernels-of-combinations", &rows);
    assert!(changed.is_empty(), "{} rows changed, see kernels/same_kernels: {changed:#?}", changed.len());
}

#[test]
#[ignore = "minutes: make test-long"]
fn every_combination_of_features_is_valid_in_each_way() {
    each_combination_is_valid(&|_| &[Scatter::Fused, Scatter::Queues, Scatter::Linked]);
}

/// Returns the hashes of the kernels.
fn each_combination_is_valid(ways: &(dyn Fn(usize) -> &'static [Scatter] + Sync)) -> BTreeMap<String, Vec<String>> {
    let mut unused_lines = lines_of_code();
    assert!(unused_lines.len() > 1000, "{} lines", unused_lines.len());
    // The numerics probe is part of no render.
    let probe = link(&Embedded, "stage/probe", &Choices::default()).expect("the probe links");
    unused_lines.retain(|line| !probe.lines.contains(line));
    let all: Vec<_> = combinations().into_iter().enumerate().collect();
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let unused_after = &|first: usize| {
        let (mut unused, mut rows) = (unused_lines.clone(), BTreeMap::new());
        for (number, (features, options)) in all.iter().skip(first).step_by(cores) {
            for &scatter in ways(*number) {
                let kernels = kernels(features, options, scatter);
                check_combination(&kernels, features, options, &mut unused);
                rows.insert(format!("{number:04}, {scatter:?}"), hashes(&kernels));
            }
        }
        (unused, rows)
    };
    let found = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..cores).map(|first| scope.spawn(move || unused_after(first))).collect();
        let each = threads.into_iter().map(|thread| thread.join().expect("every combination is valid"));
        each.reduce(|(a, rows), (b, more)| {
            (a.intersection(&b).cloned().collect(), rows.into_iter().chain(more).collect())
        })
    });
    let (unused, rows) = found.expect("a thread");
    assert_eq!(unused, BTreeSet::new());
    rows
}

/// The kernels of a combination have nothing that it does not require. Removes their lines.
fn check_combination(
    plan: &Kernels,
    features: &Features,
    options: &RenderOptions,
    unused_lines: &mut BTreeSet<(String, usize)>,
) {
    assert!(!plan.all().is_empty());
    for kernel in plan.all() {
        for line in &kernel.linked.lines {
            unused_lines.remove(line);
        }
        // Nothing that the scene lacks.
        let has = |group: &str, kind: &str| features.reason(&format!("{group}.{kind}")).is_some();
        let unused = |names: &[&str], group: &str, folder: &str| {
            let off = names.iter().filter(|name| !has(group, name));
            off.map(|name| format!("{folder}/{name}")).collect::<Vec<_>>()
        };
        // A closed mesh is made of triangles.
        let bounds = |kind: &str| has("boundary", if kind == "triangle" { "mesh" } else { kind });
        // The glass of glTF's material is that of others.
        let has_share = features.any("transmission").is_some();
        let of_share = ["material/rough_dielectric", "material/thin_dielectric"];
        let lacking = [
            unused(PRIMITIVES, "shape", "geometry"),
            unused(MATERIALS, "material", "material"),
            unused(TEXTURES, "texture", "texture"),
            unused(FORMATS, "texel", "texel"),
        ];
        // Nor approximations, unless requested, nor Fresnel's reflection without what reflects by it.
        let any_material = |is_so: fn(&MaterialKind) -> bool| {
            Material::KINDS.iter().zip(MATERIALS).any(|(kind, name)| is_so(kind) && has("material", name))
        };
        let glass = has_share || any_material(|kind| kind.is_transmissive || kind.can_have(ROUGH_LAYER));
        for (module, is_requested) in [
            ("lib/fresnel", glass && options.fresnel == Fresnel::Exact),
            ("lib/fresnel_schlick", glass && options.fresnel == Fresnel::Schlick),
            ("step/clamp", options.clamp.is_some()),
            ("geometry/sphere_chord_fast", options.precision == Precision::Fast),
        ] {
            let linked = kernel.linked.modules.iter().any(|linked| linked == module);
            assert!(is_requested || !linked, "{}: {module} is linked: {features:?}", kernel.name);
        }
        // Nor light sampling where nothing answers to a light: in the scene, or in a kernel of some of its materials.
        let answered = answers(features);
        let own = kernel.name.strip_prefix("scatter_").map(kind_of);
        for (module, wanted) in [
            ("bind/lights", answered && features.quantities.lights > 0),
            ("step/surface_light", answered && features.quantities.lights > 0),
            // A kernel of mirrors or of glass sends probes to lights.
            (
                "scene/responses",
                answered && (own.is_none_or(spreads) || features.quantities.lights > 0) || !options.aov.is_empty(),
            ),
            // Nor a second part of materials that have one alone.
            ("scene/second_parts", any_material(|kind| !kind.second_part.is_empty())),
        ] {
            let linked = kernel.linked.modules.iter().any(|linked| linked == module);
            assert!(wanted || !linked, "{}: {module} is linked: {features:?}", kernel.name);
        }
        for module in lacking.concat() {
            if has_share && of_share.contains(&module.as_str()) {
                continue;
            }
            let aims = ["geometry/cuboid", "light/cuboid", "light/quad"].contains(&module.as_str());
            if module.strip_prefix("geometry/").is_some_and(bounds) || (aims && options.light_paths.count() > 0) {
                continue;
            }
            assert!(!kernel.linked.modules.contains(&module), "{}: {module} is linked: {features:?}", kernel.name);
        }
    }
}

/// The lines of code of all modules, as module and number.
fn lines_of_code() -> BTreeSet<(String, usize)> {
    let code = |name: &String| {
        let text = Embedded.module(name).expect("it is listed");
        let is_code = |line: &str| !line.trim().is_empty() && !line.trim().starts_with("//");
        let lines = (1..).zip(text.lines()).filter(|(_, line)| is_code(line));
        lines.map(|(number, _)| (name.clone(), number)).collect::<Vec<_>>()
    };
    Embedded::names().iter().flat_map(code).collect()
}

/// The most storage buffers that a kernel with everything on binds, all tables in storage bindings. WebGPU promises 8. Kernels
/// with everything on exceed it (docs/dev/architecture.md); this limit keeps them from growing further.
const MOST_STORAGE_BUFFERS: [(Scatter, usize); 3] =
    [(Scatter::Linked, 21), (Scatter::Queues, 23), (Scatter::Fused, 24)];

#[test]
fn no_kernel_binds_too_many_storage_buffers() {
    for (scatter, most) in MOST_STORAGE_BUFFERS {
        let kernels = kernels(&moving(many_lights(everything()), true), &RenderOptions::default(), scatter);
        let storage = |kernel: &Arc<Kernel>| {
            kernel.bindings.values().filter(|binding| binding.kind != BindingKind::Uniform).count()
        };
        assert_eq!(kernels.all().into_iter().map(storage).max(), Some(most), "{scatter:?}");
    }
}

/// The folders whose modules a folder's modules may use, and the single modules beside them. What stands behind
/// `choice/x` counts as the folder of the modules that implement it.
const MAY_USE: &str = "
lib: lib
sampler: data lib
data: data generated lib
geometry: bind/meshes data geometry lib
tangent: bind/meshes data geometry lib
light: data geometry lib light
medium: bind choice/mesh_tree data geometry lib medium motion scene/face_pairs
material: choice/inner_reflections choice/multiscatter data geometry lib lobe material
lobe: bind data lib lobe material
bind: bind data geometry/triangle scene/at_run_time
texture: choice/number_texels data lib scene/texel
camera: bind camera data lib motion
motion: bind camera choice/faces data geometry/triangle lib motion sampler
filter: data filter lib
background: bind choice/axes data lib scene/texel
texel: bind
scene: background bind data extension geometry lib light lobe material medium motion sampler scene tangent texel texture
slots: aov bind data generated lib scene slots
aov: aov bind camera data scene step
extension: bind data lib
step: aov background bind camera data filter geometry lib light light_path medium motion sampler scene step truth
light_path: aov bind camera data filter geometry lib light light_path lobe material motion sampler scene step
truth: bind camera data lib motion scene step truth
stage: aov background bind camera data generated geometry lib light_path material motion scene slots step texture truth
";

/// The uses of a module that its folder may not make, each with its line.
fn violations(module: &str, text: &str) -> Vec<String> {
    let folder = |name: &str| name.split('/').next().unwrap_or_default().to_string();
    let from = folder(module);
    let own = MAY_USE.lines().filter_map(|line| line.split_once(": ")).find(|(name, _)| *name == from);
    let Some(allowed) = own.map(|(_, allowed)| allowed.split(' ').collect::<Vec<_>>()) else {
        return vec![format!("{module}: its folder is not in the table of this test: say there what it may use")];
    };
    let mut found = Vec::new();
    let lines: Vec<&str> = text.lines().collect();
    let named = Embedded.vocabulary().used(&lines, &[]).into_iter().map(|(used, index)| (index + 1, used));
    let uses = (1..)
        .zip(text.lines())
        .filter_map(|(number, line)| Some((number, line.trim().strip_prefix("//@ use ")?.trim())));
    for (number, used) in uses.chain(named) {
        let target = match used.strip_prefix("choice/") {
            // Of the shapes, any stands for all.
            Some(choice) => match Embedded.heads().choices().get(&choice.replace("${name}", "sphere")) {
                Some(choice) => folder(&choice.heads[0].module),
                None => {
                    found.push(format!("{module}:{number}: nothing implements {used}"));
                    continue;
                }
            },
            None => folder(used),
        };
        if [target.as_str(), used].iter().all(|used| !allowed.contains(used)) {
            found.push(format!("{module}:{number}: {from} may not use {used}"));
        }
    }
    found
}

#[test]
fn modules_use_what_their_folders_may() {
    let mut uses = 0;
    for name in Embedded::names() {
        let text = Embedded.module(&name).expect("it is listed");
        let known = ["//@ use data/", "//@ use lib/"].into_iter().find(|known| text.contains(known));
        assert_eq!(known, None, "shaders/{name}.wgsl: these names need no `//@ use`");
        uses += text.lines().filter(|line| line.trim().starts_with("//@ use ")).count();
        assert_eq!(violations(&name, text), Vec::<String>::new());
    }
    assert!(uses > 100, "{uses} uses were looked at");
    // All modules behind a choice are in one folder.
    for (choice, own) in Embedded.heads().choices() {
        let folders: BTreeSet<_> = own.heads.iter().filter_map(|head| head.module.split('/').next()).collect();
        assert_eq!(folders.len(), 1, "{choice}: {folders:?}");
    }
    // Planted violations.
    for (module, used) in [
        ("lib/rng", "bind/settings"),
        ("lib/rng", "data/ray"),
        ("sampler/sobol", "bind/settings"),
        ("data/ray", "bind/paths"),
        ("geometry/sphere", "scene/traverse"),
        ("material/metal", "slots/state"),
        ("material/metal", "bind/materials"),
        ("texture/noise", "scene/uv"),
        ("texture/noise", "bind/texels"),
        ("scene/surfaces", "stage/scatter"),
        ("stage/scatter", "stage/refill"),
        ("step/scatter", "slots/state"),
        ("scene/uv", "choice/unheard"),
        ("elsewhere/x", "lib/rng"),
    ] {
        let found = violations(module, &format!("// A comment.\n    //@ use {used}\n"));
        assert_eq!(found.len(), 1, "{module} uses {used}: {found:?}");
    }
    assert_eq!(violations("texture/image", "//@ use scene/texel\n"), Vec::<String>::new());
    assert_eq!(violations("lib/rng", "fn f() -> Hit {\n").len(), 1, "a name of another folder's vocabulary");
}

/// Modules of a test beside the production ones.
struct With(BTreeMap<&'static str, &'static str>, Heads);

impl Library for With {
    fn module(&self, name: &str) -> Option<&str> {
        self.0.get(name).copied().or_else(|| Embedded.module(name))
    }

    fn heads(&self) -> &Heads {
        &self.1
    }
}

fn linked(modules: &[(&'static str, &'static str)]) -> Result<Linked, String> {
    let why = Reason::EveryRender;
    let entry = |name: &str, number, closes| Entry { name: name.to_string(), number, closes, why: why.clone() };
    let choices = Choices {
        facts: BTreeMap::from([("wet".to_string(), Some(why.clone())), ("dry".to_string(), None)]),
        lists: BTreeMap::from([("animal", vec![entry("cat", 3, false), entry("dog", 5, true)])]),
        values: BTreeMap::from([("size".to_string(), "7".to_string())]),
        generated: BTreeMap::new(),
    };
    let library = With(modules.iter().copied().collect(), Heads::of(modules.iter().copied()));
    link(&library, "test/root", &choices).map_err(|error| error.to_string())
}

/// The error of linking or validating, which must name this location.
fn assert_fault(modules: &[(&'static str, &'static str)], location: &str, about: &str) {
    let error = match linked(modules) {
        Err(error) => error,
        Ok(linked) => match linked.validate() {
            Err(error) => error.to_string(),
            Ok(_) => panic!("no error about {about}"),
        },
    };
    assert!(
        error.starts_with(location) && error.contains(about),
        "{error:?} does not start with {location}, or lacks {about}"
    );
}

#[test]
fn the_linkers_errors_name_file_and_line() {
    let missing = "// A comment.\n\n//@ use lib/nothing\n";
    assert_fault(&[("test/root", missing)], "shaders/test/root.wgsl:3:", "lib/nothing");
    let nested = "//@ use test/inner\nfn f() {}\n";
    assert_fault(&[("test/root", nested), ("test/inner", missing)], "shaders/test/inner.wgsl:3:", "lib/nothing");
    assert_fault(&[("test/root", "//@ use choice/unheard\n")], "shaders/test/root.wgsl:1:", "unheard");
    assert_fault(&[("test/root", "fn f() {}\n//@ each plant\n//@ end\n")], "shaders/test/root.wgsl:2:", "plant");
    assert_fault(
        &[("test/root", "fn f() {}\n//@ end\n")],
        "shaders/test/root.wgsl:2:",
        "without `//@ if` or `//@ each`",
    );
    assert_fault(&[("test/root", "\n//@ each animal\nfn f() {}\n")], "shaders/test/root.wgsl:3:", "without `//@ end`");
    assert_fault(&[("test/root", "fn f() {}\n//@ if cold\n//@ end\n")], "shaders/test/root.wgsl:2:", "fact `cold`");
    for (outer, inner) in
        [("if wet", "if dry"), ("if dry", "each animal"), ("each animal", "if wet"), ("each animal", "each animal")]
    {
        let text = format!("//@ {outer}\n//@ {inner}\n//@ end\n//@ end\n");
        let about = format!("`//@ {inner}` within `//@ {outer}`");
        assert_fault(&[("test/root", text.leak())], "shaders/test/root.wgsl:2:", &about);
    }
    // A block that closes a brace of other lines, or leaves one open.
    for text in
        ["//@ if wet\nfn f() {\n//@ end\n}\n", "fn f() {\n//@ if dry\n}\n//@ end\n", "//@ each animal\n} {\n//@ end\n"]
    {
        assert_fault(&[("test/root", text)], "shaders/test/root.wgsl:", "half a brace within");
    }
    assert_fault(&[("test/root", "\nconst A: u32 = ${length}u;\n")], "shaders/test/root.wgsl:2:", "length");
    assert_fault(&[("test/root", "\n\nconst A: u32 = ${size;\n")], "shaders/test/root.wgsl:3:", "without `}`");
    assert_fault(&[], "shaders/(the plan).wgsl:0:", "test/root");
    for wrong in ["//@ uses lib/rng", "//@use lib/rng", "//@ use", "//@", "//@ End", "//@ ends", "//@ if", "//@ else"] {
        let about = format!("`{wrong}` is no directive");
        let texts = [format!("fn f() {{}}\n    {wrong}\n"), format!("//@ each animal\n{wrong}\n//@ end\n")];
        for text in texts {
            assert_fault(&[("test/root", text.leak())], "shaders/test/root.wgsl:2:", &about);
        }
    }
}

#[test]
fn nagas_errors_name_the_file_and_line_of_the_module() {
    // The broken line stands behind other modules and behind directives, which leave no line in the linked text.
    let root = "//@ use lib/rng\n//@ use test/inner\n@compute @workgroup_size(1)\nfn main() { inner(); }\n";
    let syntax = "//@ use lib/float\n// A comment.\nfn inner() {\n    let x = ;\n}\n";
    assert_fault(&[("test/root", root), ("test/inner", syntax)], "shaders/test/inner.wgsl:4:", "");
    let types = "//@ use lib/float\n\nfn inner() {\n    let x = 1u;\n    let y: f32 = x;\n}\n";
    assert_fault(&[("test/root", root), ("test/inner", types)], "shaders/test/inner.wgsl:5:", "");
    // What the validator finds after a successful parse.
    let invalid = "//@ use lib/float\nfn inner() -> f32 {\n    var x = 1.0;\n    loop { break; }\n}\n";
    assert_fault(&[("test/root", root), ("test/inner", invalid)], "shaders/test/inner.wgsl:", "");
    // In a line that a list repeats, and behind the repetition.
    let repeated = "//@ each animal\nconst ${name}: u32 = ${rank}u;\n//@ end\nfn inner() {\n    let x = ;\n}\n";
    assert_fault(&[("test/root", root), ("test/inner", repeated)], "shaders/test/inner.wgsl:5:", "");
    let within = "//@ each animal\n\nconst ${name} u32 = ${rank}u;\n//@ end\nfn inner() { let x = cat; }\n";
    assert_fault(&[("test/root", root), ("test/inner", within)], "shaders/test/inner.wgsl:3:", "");
    // In the root itself.
    assert_fault(&[("test/root", "//@ use lib/rng\n\nfn main( {}\n")], "shaders/test/root.wgsl:3:", "");
}

#[test]
fn lines_of_a_condition_are_there_where_it_holds() {
    let root = "//@ if wet\nconst WET: u32 = ${size}u;\n//@ use lib/rng\n//@ end\n\
                //@ if dry\nconst DRY: u32 = ${none}u;\n//@ use no/module\n//@ end\n\
                //@ if !dry\nconst NOT_DRY: u32 = 2u;\n//@ end\n";
    let linked = linked(&[("test/root", root)]).expect("it links");
    let expected = "const WET: u32 = 7u;\nconst NOT_DRY: u32 = 2u;\n";
    assert!(linked.text.ends_with(expected), "{}", linked.text);
    assert_eq!(linked.modules, ["lib/rng", "test/root"]);
}

/// The lines of a module that begin a condition outside of a struct.
fn conditions_outside_structs(text: &str) -> Vec<&str> {
    let mut in_struct = false;
    let is_outside = |line: &&str| {
        in_struct = (in_struct || line.starts_with("struct ")) && !line.starts_with('}');
        line.trim().starts_with("//@ if ") && !in_struct
    };
    text.lines().filter(is_outside).collect()
}

/// What depends on a fact is a member of a struct, or a function of a file of its own, so that a function reads as what it does.
#[test]
fn no_function_has_a_condition() {
    for name in Embedded::names() {
        let text = Embedded.module(&name).expect("it is listed");
        assert_eq!(conditions_outside_structs(text), Vec::<&str>::new(), "shaders/{name}.wgsl");
    }
    let planted =
        "struct A {\n    //@ if wet\n    a: u32,\n    //@ end\n}\n\nfn f() {\n    //@ if dry\n    //@ end\n}\n";
    assert_eq!(conditions_outside_structs(planted), ["    //@ if dry"]);
}

/// What shaders name and what the plan decides are the same names: none is unknown, and no list or value is decided for nothing.
#[test]
fn directives_name_what_the_plan_decides_and_all_of_that() {
    let mut named: [BTreeSet<String>; 4] = Default::default();
    let [facts, lists, choices, values] = &mut named;
    let decided = choices_of(&Features::default(), &RenderOptions::default(), &UniformTables::default());
    let of_files = Embedded::names().into_iter().map(|name| Embedded.module(&name).expect("it is listed").to_string());
    for text in of_files.chain(decided.generated.values().cloned()) {
        let mut is_in_list = false;
        for line in text.lines().map(str::trim) {
            if let Some(condition) = line.strip_prefix("//@ if ") {
                facts.extend(When::parse(condition).expect(condition).facts().into_iter().map(str::to_string));
            }
            match line.split_whitespace().collect::<Vec<_>>()[..] {
                ["//@", "each", list] => {
                    is_in_list = true;
                    lists.insert(list.to_string());
                }
                ["//@", "end"] => is_in_list = false,
                ["//@", "use", "choice/moved_${name}"] => {
                    let shapes = PRIMITIVES.iter().filter(|name| **name != "triangle");
                    choices.extend(shapes.map(|name| format!("moved_{name}")));
                }
                ["//@", "use", used] => choices.extend(used.strip_prefix("choice/").map(str::to_string)),
                _ if is_in_list => {}
                _ => {
                    values.extend(line.split("${").skip(1).filter_map(|rest| Some(rest.split_once('}')?.0.to_string())))
                }
            }
        }
    }
    let heads = Embedded.heads().choices();
    for head in heads.values().flat_map(|choice| &choice.heads) {
        let when = head.when.as_ref().unwrap_or_else(|error| panic!("{}: {error}", head.module));
        facts.extend(when.facts().into_iter().map(str::to_string));
    }
    let unknown: Vec<_> = facts.iter().filter(|fact| !decided.facts.contains_key(*fact)).collect();
    assert_eq!(unknown, Vec::<&String>::new());
    assert_eq!(*choices, heads.keys().cloned().collect());
    assert_eq!(*lists, decided.lists.keys().map(|list| list.to_string()).collect());
    assert_eq!(*values, decided.values.keys().map(|value| value.to_string()).collect());
}

/// The conditions of facts that follow from others can be read, and name facts that are known before them.
#[test]
fn derived_facts_follow_from_those_before_them() {
    let decided = choices_of(&Features::default(), &RenderOptions::default(), &UniformTables::default());
    let mut known: BTreeSet<&str> = decided.facts.keys().map(String::as_str).collect();
    for (name, _) in CONDITIONS.iter() {
        assert!(known.remove(name.as_str()), "{name} is there twice, or no fact");
    }
    for (name, when) in CONDITIONS.iter() {
        let when = when.as_ref().unwrap_or_else(|error| panic!("{name}: {error}"));
        let unknown: Vec<_> = when.facts().into_iter().filter(|fact| !known.contains(fact)).collect();
        assert!(unknown.is_empty(), "{name} names {unknown:?}");
        known.insert(name);
    }
}

/// The truth of facts: all of them, but for the values of an option, of which one holds, and for projections, of which one may hold.
fn assignments(facts: &BTreeSet<&str>) -> Vec<BTreeMap<String, Option<Reason>>> {
    let option =
        |fact: &&&str| TRADE_OFFS.iter().find(|spec| fact.split_once('.').is_some_and(|(name, _)| name == spec.name));
    let is_projection = |fact: &str| fact.starts_with("projection.");
    let (values, free): (Vec<&&str>, Vec<&&str>) = facts
        .iter()
        .filter(|fact| **fact != "projection")
        .partition(|fact| option(fact).is_some() || is_projection(fact));
    let is_of_projections = values.iter().any(|fact| is_projection(fact));
    let holds = |is_so: bool| is_so.then_some(Reason::EveryRender);
    // A further value stands for those that no module names.
    let of_option =
        |chosen: usize| values.iter().enumerate().map(move |(i, fact)| (fact.to_string(), holds(i == chosen)));
    let of_bits =
        |bits: usize| free.iter().enumerate().map(move |(i, fact)| (fact.to_string(), holds(bits >> i & 1 == 1)));
    let is_complete = |chosen: &usize| {
        *chosen < values.len()
            || option(values.first().unwrap_or(&&"")).is_none_or(|spec| spec.values.len() > values.len())
    };
    let chosen: Vec<usize> = (0..=values.len()).filter(is_complete).collect();
    let each = (0..1 << free.len()).flat_map(|bits| chosen.iter().map(move |chosen| (bits, *chosen)));
    let any = |chosen: usize| ("projection".to_string(), holds(is_of_projections && chosen < values.len()));
    each.map(|(bits, chosen)| of_bits(bits).chain(of_option(chosen)).chain([any(chosen)]).collect()).collect()
}

/// Whatever the facts are, one part of a choice is there.
#[test]
fn one_part_of_a_choice_holds_whatever_the_facts_are() {
    let mut tried = 0;
    let mut choose = |heads: &Heads, choice: &str| {
        let facts =
            heads.choices()[choice].heads.iter().flat_map(|head| head.when.as_ref().expect("it is right").facts());
        let facts: Vec<_> = assignments(&facts.collect());
        tried += facts.len();
        facts.iter().find_map(|facts| Some(format!("{}: {facts:?}", heads.choose(choice, facts).err()?)))
    };
    for choice in Embedded.heads().choices().keys() {
        assert_eq!(choose(Embedded.heads(), choice), None, "{choice}");
    }
    // Two that hold, and none.
    for (other, about) in [("when !wet | dry", "both implement"), ("when !wet & dry", "no module")] {
        let text = format!("//@ implements x {other}\n");
        let heads = Heads::of([("a", "//@ implements x when wet\n"), ("b", text.as_str())]);
        assert!(choose(&heads, "x").is_some_and(|error| error.contains(about)), "{other}");
    }
    assert!(tried > 250, "{tried}");
}

/// The number of rows of facts, and for each fact the rows in which it holds, as bits. Two facts hold both, either without the other, and neither in
/// some row: each has as many rows as the others, all have the last one, and no two have the same (Kleitman and Spencer, "Families of k-independent
/// sets", 1973).
const ROWS: u32 = 12;

fn facts_in_rows() -> Vec<(String, u32)> {
    // A scene has one background and one projection.
    let one_of = |fact: &String| ["background.image", "projection.fisheye"].contains(&fact.as_str());
    let is_of_group = |fact: &String| ["background.", "projection."].iter().any(|group| fact.starts_with(group));
    let facts = DECLARED.iter().flat_map(Declared::facts).filter(|fact| !is_of_group(fact) || one_of(fact));
    let facts: Vec<String> = facts.collect();
    let rows: Vec<u32> = (1 << (ROWS - 1)..1 << ROWS).filter(|rows: &u32| rows.count_ones() == ROWS / 2).collect();
    assert!(facts.len() <= rows.len(), "{} facts need more rows", facts.len());
    facts.into_iter().zip(rows).collect()
}

/// Kernels of scenes in which any two facts hold or do not are valid. (Facts that need others bring these.)
#[test]
fn every_pair_of_facts_is_valid() {
    let all = facts_in_rows();
    let is_in_all_ways =
        |a: u32, b: u32| [a & b, a & !b, b & !a, !(a | b) & ((1 << ROWS) - 1)].iter().all(|rows| *rows != 0);
    let pairs = all.iter().enumerate().flat_map(|(i, (_, a))| all[..i].iter().map(move |(_, b)| (*a, *b)));
    assert!(all.len() > 120, "{} facts", all.len());
    assert!(pairs.into_iter().all(|(a, b)| is_in_all_ways(a, b)));
    for number in 0..ROWS {
        let facts = all.iter().filter(|(_, rows)| rows >> number & 1 == 1);
        let facts: Vec<&str> = facts.map(|(fact, _)| fact.as_str()).collect();
        let mut found = having(features(1, 1, 0, IMAGE, false), &facts);
        // Facts of a scene that come with one of a group.
        for (fact, group) in [
            ("light_paths", "specular_lobe"),
            ("textured_medium", "boundary"),
            ("textured_medium", "texture"),
            ("textured_light", "texture"),
            ("textured_pane", "texture"),
            ("moving_medium", "boundary_moves"),
            ("medium_emission", "boundary"),
            ("blackbody", "boundary"),
        ] {
            if found.any(group).is_none() {
                found.forget(fact);
            }
        }
        let lights =
            ["area_light", "sky_light", "delta_light"].iter().filter(|group| found.any(group).is_some()).count();
        let found = quantified(found, |own| {
            (own.media, own.boundary_stack_size, own.lights) =
                (facts.iter().filter(|fact| fact.starts_with("boundary.")).count() as u32, 8, lights as u32);
            (own.aims, own.motion_iterations, own.sky_grid) = (3, 3, (4, 2));
        });
        let light_paths = if number % 2 == 0 { LightPaths::Count(1) } else { LightPaths::Off };
        let options = RenderOptions { light_paths, ..RenderOptions::default() };
        kernels(&found, &options, if number % 3 == 0 { Scatter::Queues } else { Scatter::Fused });
    }
}

/// The functions that a text declares: their names and all up to the body.
fn signatures(text: &str) -> BTreeSet<String> {
    let declared = text.split("\nfn ").skip(1).filter_map(|rest| Some(rest.split_once(" {")?.0));
    declared.map(|signature| signature.split_whitespace().collect::<String>().replace(",)", ")")).collect()
}

/// What stands in the place of a feature has the functions of the feature.
#[test]
fn parts_have_the_same_functions() {
    let missing = |text: &str| -> Vec<String> {
        let (own, without) = text.split_once("\n//@ without").unwrap_or((text, ""));
        signatures(without).difference(&signatures(own)).cloned().collect()
    };
    let mut parts = 0;
    for name in Embedded::names() {
        let text = Embedded.module(&name).expect("it is listed");
        parts += usize::from(text.contains("\n//@ without\n"));
        assert_eq!(missing(text), Vec::<String>::new(), "{name}");
    }
    assert!(parts > 60, "{parts}");
    let text = "//@ implements x when wet\nfn f(\n    a: u32,\n) -> u32 {\n}\n//@ without\nfn f(a: u32) -> u32 {\n}\n";
    assert_eq!(missing(text), Vec::<String>::new());
    assert_eq!(missing(&text.replace("fn f(a: u32)", "fn f(a: i32)")).len(), 1);
}

#[test]
fn heads_choose_the_part_of_a_module() {
    let root = "//@ use choice/rain\n//@ use choice/snow\nfn root() {\n    rain();\n    snow();\n}\n";
    let rain = "//@ implements rain when wet & !dry\n//@ use lib/rng\nfn rain() {\n}\n\n//@ without\n//@ use no/module\nfn rain() {\n    return;\n}\n";
    let snow = "//@ implements snow when dry | (dry & wet)\n//@ implements hail when wet\n//@ use no/module\nfn snow() {\n}\n\n\
                //@ without\nfn snow() {\n    return;\n}\n";
    let modules = [("test/root", root), ("test/rain", rain), ("test/snow", snow)];
    let found = linked(&modules).expect("it links");
    assert!(
        found.text.ends_with("fn rain() {\n}\nfn snow() {\n    return;\n}\nfn root() {\n    rain();\n    snow();\n}\n"),
        "{}",
        found.text
    );
    assert_eq!(found.modules, ["lib/rng", "test/rain", "test/root"]);
    assert_eq!(found.choices, BTreeMap::from([("rain".to_string(), "test/rain".to_string())]));
    // A use of the module itself means the part under the head.
    let direct =
        linked(&[("test/root", "//@ use test/rain\nfn root() {\n    rain();\n}\n"), modules[1]]).expect("it links");
    assert!(direct.text.ends_with("fn rain() {\n}\nfn root() {\n    rain();\n}\n"), "{}", direct.text);
    // Lines count from the beginning of the file in either part.
    let wrong = snow.replace("    return;", "    return x;");
    assert_fault(&[modules[0], modules[1], ("test/snow", wrong.leak())], "shaders/test/snow.wgsl:9:", "");
    let uses = |text: &'static str| [("test/root", "\n//@ use choice/rain\n"), ("test/rain", text)];
    for (text, about) in [
        ("fn rain() {\n}\n", "no module implements `rain`"),
        ("//@ implements rain when dry\n", "no module that implements `rain`"),
        ("//@ implements rain when cold\n", "the plan has no fact `cold`, in the head of test/rain"),
        ("//@ implements rain when wet &\n", "a fact is missing"),
        ("//@ implements rain when (wet\n", "no `)`"),
        ("//@ implements rain when wet dry\n", "left over"),
        ("//@ implements rain\n", "a fact is missing"),
        ("//@ implements rain when wet\n//@ alternative rain when wet\n", "both implement `rain`"),
    ] {
        assert_fault(&uses(text), "shaders/test/root.wgsl:2:", about);
    }
    assert_fault(
        &uses("//@ implements rain when wet\n\n//@ implements snow when wet\n"),
        "shaders/test/rain.wgsl:3:",
        "no directive",
    );
}

#[test]
fn modules_are_joined_once_and_lists_and_values_filled_in() {
    let root = "//@ use lib/rng\n//@ use test/inner\n//@ use choice/known\nfn number(kind: u32) -> u32 {\n    switch kind {\n\
                //@ each animal\n        ${case}: { return ${name}() + ${rank}u; }\n//@ end\n    }\n}\n";
    let inner =
        "//@ use lib/rng\n//@ each animal\nfn ${name}() -> u32 { return 1u; }\n//@ end\nconst SIZE: u32 = ${size}u;\n";
    let known = "//@ implements known when wet\n//@ use lib/rng\n";
    let linked = linked(&[("test/root", root), ("test/inner", inner), ("test/known", known)]).expect("it links");
    assert_eq!(linked.modules, ["lib/rng", "test/inner", "test/root"]);
    assert_eq!(linked.text.matches("fn pcg4d(").count(), 1);
    for text in ["case 3u: { return cat() + 0u; }", "default: { return dog() + 1u; }", "const SIZE: u32 = 7u;"] {
        assert!(linked.text.contains(text), "{text}");
    }
    assert_eq!(linked.text.lines().count(), linked.lines.len());
    for (line, (module, number)) in linked.text.lines().zip(&linked.lines) {
        if module == "lib/rng" {
            let own = Embedded.module(module).expect("it is there").lines().nth(number - 1);
            assert_eq!(own, Some(line));
        }
    }
    linked.validate().expect("it is valid");
}

#[test]
fn only_what_an_entry_point_reaches_is_kept() {
    let inner = "// A comment.
struct Kept {
    // Another comment.
    x: f32, // and a third
    unused_like_a_member: f32,
}
struct Unused { x: Kept }
const SIZE: u32 = 4u;
const TWICE: u32 = 2u * SIZE;
const LONE: u32 = 1u;
override CHOSEN: u32 = 2u;
@group(0) @binding(0)
var<storage, read_write> words: array<u32>;
@group(0) @binding(1) var<uniform> others: vec4<u32>;
fn unused() -> u32 {
    return LONE + others.x;
}
fn unused_like_a_member() {}
fn helper(kept: Kept) -> f32 {
    for (var i = 0u; i < TWICE; i++) { words[i] = CHOSEN; }
    return kept.unused_like_a_member;
}
";
    let root = "//@ use test/inner\n//@ use lib/rng\n@compute @workgroup_size(1)\nfn main() {\n    let x = helper(Kept(1.0, 2.0));\n}\n";
    let linked = linked(&[("test/root", root), ("test/inner", inner)]).expect("it links");
    for kept in "struct Kept|SIZE|TWICE|CHOSEN|var<storage|@binding(0)|fn helper|fn main|    x: f32,\n".split('|') {
        assert!(linked.text.contains(kept), "{kept} is missing:\n{}", linked.text);
    }
    for gone in ["Unused", "LONE", "others", "fn unused()", "fn unused_like", "omment", "third", "pcg4d", "@binding(1)"]
    {
        assert!(!linked.text.contains(gone), "{gone} is left:\n{}", linked.text);
    }
    assert_eq!(linked.modules, ["test/inner", "test/root"]);
    linked.validate().expect("it is valid");
    // Without an entry point everything stays, for whoever wants to see it.
    let all = linked_all(inner);
    assert!(all.contains("Unused") && all.contains("LONE") && all.contains("fn unused()"), "{all}");
}

fn linked_all(text: &'static str) -> String {
    linked(&[("test/root", text)]).expect("it links").text
}

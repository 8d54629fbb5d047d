//! The host's side of what the device reads and writes, which build.rs writes, against naga's reflection of the WGSL: the structs field by
//! field, and the constants.

use std::collections::BTreeMap;

use gpu_rt::aov::Aovs;
use gpu_rt::data;
use gpu_rt::flatten::{Features, MATERIALS, Quantities};
use gpu_rt::gpu::layout::{Member, members, pack};
use gpu_rt::gpu::link::{Choices, Embedded, link};
use gpu_rt::options::{FeatureSet, Fresnel, LightPaths, RenderOptions, Scatter};
use gpu_rt::plan::{Code, Kernels, PathField, UniformTables, path_layout};

#[allow(dead_code)]
#[path = "../../build.rs"]
mod build;

/// Name, offset and bytes of each field.
type Fields = Vec<(String, usize, usize)>;

/// The modules of every production kernel with every feature on, and the numerics probe's.
fn modules() -> Vec<naga::Module> {
    let probe = link(&Embedded, "stage/probe", &Choices::default()).expect("the probe links");
    let (probe, _) = probe.validate().expect("the probe is valid");
    linked(LightPaths::Off).into_iter().chain(std::iter::once(probe)).collect()
}

/// Those modules, and those of renders with light paths, whose films have more sums, with words of sample 0, and with mattes.
fn all_modules() -> Vec<naga::Module> {
    let projections = ["calibrated", "calibrated_fisheye"].map(|projection| linked_as(projection, "", LightPaths::Off));
    let truth = linked_as("fisheye", "motion", LightPaths::Off);
    let mattes = linked_as("fisheye", "cryptomatte", LightPaths::Off);
    [modules(), linked(LightPaths::Count(8)), projections.concat(), truth, mattes].concat()
}

/// The modules of every production kernel with every feature on.
fn linked(light_paths: LightPaths) -> Vec<naga::Module> {
    linked_as("fisheye", "", light_paths)
}

/// The same with this projection, and with a channel, if one is named.
fn linked_as(projection: &str, channel: &str, light_paths: LightPaths) -> Vec<naga::Module> {
    let mut features =
        Features::default().with_options(&RenderOptions { features: FeatureSet::All, ..RenderOptions::default() });
    for fact in ["light_paths", "varying.height", "varying.grid", "medium_emission", "blackbody"] {
        features.require(fact, || "a test".to_string());
    }
    features.require(format!("projection.{projection}"), || "a test".to_string());
    features.quantities = Quantities {
        motion_iterations: 8,
        media: 3,
        stack_size: 8,
        boundary_stack_size: 8,
        sky_grid: (4, 2),
        lights: 1000,
        sky_light: 999,
        aims: 3,
        shadow_rays: true,
        alpha_textures: true,
        alpha_on_bodies: true,
        pane_textures: true,
        ..Quantities::default()
    };
    [Scatter::Fused, Scatter::Linked, Scatter::Queues]
        .into_iter()
        .flat_map(|scatter| {
            let mut options =
                RenderOptions { fresnel: Fresnel::Schlick, clamp: Some(1.0), light_paths, ..RenderOptions::default() };
            options.aov.set(Aovs::parse(channel).unwrap_or_default());
            let kernels =
                Kernels::link(&features, &options, scatter, &UniformTables::default()).expect("everything links");
            kernels.all().into_iter().map(|kernel| kernel.module.clone()).collect::<Vec<_>>()
        })
        .collect()
}

/// The struct as each kernel that has it lays it out.
fn layouts(modules: &[naga::Module], name: &str) -> Vec<(Fields, usize)> {
    let of_module = |module| members(module, name).expect("naga lays every type out");
    let found = modules.iter().filter_map(of_module).map(|(members, size)| {
        let fields = members.into_iter().map(|m| (m.name, m.offset as usize, m.bytes as usize)).collect();
        (fields, size as usize)
    });
    found.collect()
}

/// Says how the host's struct differs from the shaders'.
fn difference(modules: &[naga::Module], name: &str, fields: &Fields, size: usize) -> Option<String> {
    let layouts = layouts(modules, name);
    if layouts.is_empty() {
        return Some(format!("no kernel has a struct {name}"));
    }
    layouts.iter().find_map(|(theirs, their_size)| {
        if *their_size != size {
            return Some(format!("{name} has {size} bytes here and {their_size} in WGSL"));
        }
        let pairs = fields.iter().map(Some).chain(std::iter::repeat(None));
        let mut pairs = pairs.zip(theirs.iter().map(Some).chain(std::iter::repeat(None)));
        let (own, their) = pairs.find(|(own, their)| own != their || own.is_none())?;
        (own != their).then(|| format!("{name}: {own:?} here, {their:?} in WGSL"))
    })
}

/// The structs of the host by name: their fields and bytes.
fn host_structs() -> BTreeMap<&'static str, (Fields, usize)> {
    let owned = |fields: data::Fields| fields.iter().map(|(name, at, bytes)| (name.to_string(), *at, *bytes)).collect();
    data::STRUCTS.iter().map(|(name, size, fields)| (*name, (owned(fields), *size))).collect()
}

#[test]
fn every_struct_of_the_host_is_laid_out_as_in_wgsl() {
    // The totals of a pixel have more sums with light paths, which alone have a table for the alias method.
    let (without, with) = (modules(), linked(LightPaths::Count(8)));
    // The settings have a test of their own.
    for (name, (fields, size)) in host_structs().iter().filter(|(name, _)| **name != "Settings") {
        let modules = if *name == "AliasEntry" { &with } else { &without };
        assert_eq!(difference(modules, name, fields, *size), None);
    }
}

#[test]
fn the_host_has_what_bindings_hold_and_says_where_it_cannot() {
    let translated = |member: &str| {
        let text = format!("// A thing.\nstruct Thing {{\n    {member}\n}}\nstruct Other {{\n    flag: bool,\n}}\n");
        let mut host = build::Host::default();
        host.add("shaders/data/thing.wgsl", &text, "var<uniform> things: array<Thing, 4>;").map(|()| host.text())
    };
    for (wgsl, rust) in [
        ("a: vec3<f32>,", "a: [f32; 3],"),
        ("a: array<array<atomic<u32>, 2>, 6u>,", "a: [[u32; 2]; 6],"),
        ("a: array<i32, LENGTH>,", "a: [i32; LENGTH as usize],"),
        ("a: array<vec2<u32>, ${of_plan}>,", "a: [[u32; 2]; OF_PLAN],"),
    ] {
        let text = translated(wgsl).expect(wgsl);
        assert!(text.contains(&format!("/// A thing.\nThing {{\n{rust}\n")) && !text.contains("Other"), "{text}");
    }
    for member in ["a: bool,", "a: Other,", "a: array<u32>,", "@align(16) a: u32,", "a: mat3x3<f32>,", "a: vec3f,"] {
        let error = translated(member).expect_err(member);
        assert!(
            error.starts_with("shaders/data/thing.wgsl:3: the host cannot have `a") || member.starts_with('@'),
            "{error}"
        );
    }
}

/// The settings are placed by the names of their members, of which kernels have those that they need.
#[test]
fn every_setting_of_a_kernel_is_one_of_the_hosts() {
    let modules = all_modules();
    // Each byte shows where it comes from, so that a member at a wrong offset is found.
    let words: Vec<u32> = (1..).take(size_of::<data::Settings>() / 4).collect();
    let host: &[u8] = bytemuck::cast_slice(&words);
    let host_word = |name: &str| {
        let (_, offset, bytes) = data::Settings::FIELDS.iter().find(|(field, ..)| *field == name)?;
        Some((words[offset / 4], *bytes))
    };
    let mut seen = std::collections::BTreeSet::new();
    for module in &modules {
        let Some((members, size)) = members(module, "Settings").expect("naga lays it out") else { continue };
        let packed = pack(&members, data::Settings::FIELDS, host);
        assert!(packed.len() as u32 <= size);
        for member in members {
            let at = member.offset as usize;
            let first = u32::from_le_bytes(packed[at..at + 4].try_into().expect("four bytes"));
            assert_eq!(Some((first, member.bytes as usize)), host_word(&member.name), "{}", member.name);
            seen.insert(member.name);
        }
    }
    let fields: std::collections::BTreeSet<String> =
        data::Settings::FIELDS.iter().map(|(name, ..)| name.to_string()).collect();
    // A scene of few primitives is linked another way.
    assert_eq!(fields.difference(&seen).collect::<Vec<_>>(), ["brute_force"]);
    // What the host lacks, or has in another size, is not taken from anywhere.
    let odd = [
        Member { name: "seed".to_string(), offset: 0, bytes: 8 },
        Member { name: "sead".to_string(), offset: 8, bytes: 4 },
    ];
    assert_eq!(pack(&odd, data::Settings::FIELDS, host), [0; 16]);
}

#[test]
fn the_comparison_finds_what_differs() {
    let modules = all_modules();
    let (fields, size) = host_structs().remove("Sphere").expect("it is listed");
    let mut shifted = fields.clone();
    shifted[2].1 += 4;
    let mut renamed = fields.clone();
    renamed[1].0 = "diameter".to_string();
    let mut swapped = fields.clone();
    swapped.swap(2, 3);
    let mut wider = fields.clone();
    wider[0].2 = 16;
    let shorter = fields[..fields.len() - 1].to_vec();
    let mut longer = fields.clone();
    longer.push(("more".to_string(), size, 4));
    for wrong in [shifted, renamed, swapped, wider, shorter, longer] {
        assert!(difference(&modules, "Sphere", &wrong, size).is_some(), "{wrong:?}");
    }
    assert!(difference(&modules, "Sphere", &fields, size + 16).is_some());
    assert!(difference(&modules, "Ellipsoid", &fields, size).is_some());
    assert_eq!(difference(&modules, "Sphere", &fields, size), None);
}

/// The value of an integer constant of the shaders, which must be one in all kernels that have it.
fn constant(modules: &[naga::Module], name: &str) -> Option<u32> {
    let value = |module: &naga::Module| {
        let (_, constant) = module.constants.iter().find(|(_, constant)| constant.name.as_deref() == Some(name))?;
        let mut init = constant.init;
        loop {
            match module.global_expressions[init] {
                naga::Expression::Literal(naga::Literal::U32(value)) => return Some(value),
                naga::Expression::Constant(other) => init = module.constants[other].init,
                ref other => panic!("{name} is {other:?}"),
            }
        }
    };
    let found: Vec<u32> = modules.iter().filter_map(value).collect();
    assert!(found.iter().all(|value| *value == found[0]), "{name} is {found:?}");
    found.first().copied()
}

#[test]
fn every_constant_of_the_host_is_that_of_the_shaders() {
    let modules = all_modules();
    for (name, value) in data::CONSTANTS.iter().chain([&("RUN_LENGTH", data::RUN_LENGTH)]) {
        assert_eq!(constant(&modules, name), Some(*value), "{name}");
    }
    // Those that the shaders say in other words.
    assert_eq!(data::MAX_PRIMITIVES as u64, u64::from(data::PRIMITIVE_INDEX_MASK) + 1);
    let bits = data::LIGHT_NODE_LEAF | data::LIGHT_NODE_TWO_SIDED | data::LIGHT_NODE_SKY;
    assert_eq!(data::LIGHT_NODE_INDEX, !bits);
    // A queue's length stands before the queues, one word for each kind of material.
    assert!(data::QUEUE_HEADER as usize >= MATERIALS.len());
    // No primitive's code is a status: the kinds stop short of the last one.
    let first = constant(&modules, "FIRST_STATUS").expect("it is in data/primitive");
    let kinds = data::KIND_INSTANCE + 1;
    assert_eq!(gpu_rt::flatten::PRIMITIVES[data::KIND_TRIANGLE as usize], "triangle");
    assert!(gpu_rt::flatten::PRIMITIVES.len() <= data::KIND_DELTA_LIGHT as usize);
    assert!(data::PRIMITIVE_BIT | (kinds << data::PRIMITIVE_KIND_SHIFT) <= first);
    assert!([data::HIT_NOTHING, data::SLOT_IDLE].iter().all(|status| *status >= first));
    // It would find a wrong value.
    assert_ne!(constant(&modules, "HIT_NOTHING"), Some(data::SLOT_IDLE));
    assert_eq!(constant(&modules, "NO_SUCH_CONSTANT"), None);
}

/// No two vectors or words overlap, and all lie within the bytes of a slot, for any numbers of both.
#[test]
fn every_field_has_words_of_its_own() {
    let names = ["a", "b", "c", "d", "e", "f", "g", "h", "i", "j"];
    for vectors in 0..5 {
        for words in 0..10 {
            let field = |name: &str, words| PathField {
                name: name.to_string(),
                words,
                w_of: None,
                what: String::new(),
                why: String::new(),
                group: "ray",
                member: String::new(),
                code: Code::Word,
            };
            let vectors_of = ["A", "B", "C", "D"].into_iter().take(vectors).map(|name| field(name, 3));
            let fields: Vec<_> = vectors_of.chain(names.into_iter().take(words).map(|name| field(name, 1))).collect();
            let layout = path_layout(&fields);
            let of_vectors = layout.planes.iter().flat_map(|(_, plane)| (0..3).map(move |i| 4 * plane + i));
            let mut taken: Vec<u32> = of_vectors.chain(layout.words.iter().map(|(_, word)| *word)).collect();
            assert!(taken.iter().all(|word| u64::from(*word) * 4 < layout.plane_bytes()), "{layout:?}");
            taken.sort_unstable();
            taken.dedup();
            assert_eq!(taken.len() + layout.others.len(), 3 * vectors + words, "{layout:?}");
        }
    }
}

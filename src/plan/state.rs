//! The state of a path that slots keep from one dispatch to the next: the fields that the kernels of a scene pass to each other, and their
//! layout in memory.

use std::fmt::Write;

use crate::aov::{Aovs, Finder};
use crate::gpu::link::{Facts, Reason, reason_of};

/// The reason for fields that separate stages pass to each other.
const A_KERNEL_A_STAGE: &str = "a kernel a stage";

/// A field of the paths' state: words of 32 bits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PathField {
    /// The name in `shaders/slots`.
    pub name: String,
    pub words: u32,
    /// The vector with which it shares a vec4, as its fourth word.
    pub w_of: Option<&'static str>,
    pub what: String,
    /// The reason for it.
    pub why: String,
    /// The group of fields that stages load and store together.
    pub group: &'static str,
    /// The member of the shaders' `Path` that holds it.
    pub member: String,
    pub code: Code,
}

/// How a field is encoded in a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Code {
    Float,
    Word,
    /// Packed with the history of the path's lobes by the module behind `choice/probe`.
    Depth,
}

impl PathField {
    /// "shadow origin" of shadow_origin.
    pub fn label(&self) -> String {
        self.name.to_lowercase().replace('_', " ")
    }

    pub fn bytes(&self) -> u64 {
        u64::from(self.words) * 4
    }

    /// Whether a kernel with declarations of these names reads or writes it.
    pub fn is_used(&self, has: impl Fn(&str) -> bool) -> bool {
        match (self.words, self.w_of) {
            (1, None) => has(&format!("load_{}", self.name)) || has(&format!("store_{}", self.name)),
            _ => has(&format!("PLANE_OF_{}", self.w_of.unwrap_or(&self.name))),
        }
    }

    /// The statement that sets it from a word.
    fn taken_from(&self, word: &str) -> String {
        let member = &self.member;
        match self.code {
            Code::Float => format!("(*path).{member} = bitcast<f32>({word});"),
            Code::Word => format!("(*path).{member} = {word};"),
            Code::Depth => format!("unpack_depth(path, {word});"),
        }
    }

    /// The expression of the word that holds it.
    fn as_word(&self) -> String {
        let member = &self.member;
        match self.code {
            Code::Float => format!("bitcast<u32>((*path).{member})"),
            Code::Word => format!("(*path).{member}"),
            Code::Depth => "pack_depth(path)".to_string(),
        }
    }
}

/// The most bytes of a path's state in any scene: without channels of `--aov`, and what these add.
const MOST_PATH_BYTES: u64 = 168;
const MOST_BYTES_OF_AOVS: u64 = 80;
/// The bytes of a group of lights: its radiance of the sample, and its sums.
const BYTES_OF_A_GROUP: u64 = 24;
/// What light paths add.
const MOST_BYTES_OF_LIGHT_PATHS: u64 = 36;

/// The most bytes of a path's state in any scene with these channels.
pub fn most_path_bytes(aovs: &Aovs, light_paths: bool) -> u64 {
    let of_light_paths = if light_paths { MOST_BYTES_OF_LIGHT_PATHS } else { 0 };
    let of_groups = BYTES_OF_A_GROUP * aovs.groups().len() as u64;
    MOST_PATH_BYTES + of_light_paths + of_groups + if aovs.is_empty() { 0 } else { MOST_BYTES_OF_AOVS }
}

/// The member of a path that holds the sums of `--aov`.
const AOV: &str = "aov";
/// The member that holds the radiance of a sample by groups of lights.
const LIGHT: &str = "light_of_group";

/// The members of a path that are no fields: structs, whose members are fields; the history, which is packed with the depth; what panes
/// let pass of a shadow ray, from its walk to its light; the densities of that light's direction by all techniques of camera paths;
/// what a light path keeps between its event and the film, and the light paths that an invocation has started.
const OTHER_MEMBERS: [(&str, &str); 10] = [
    ("ray", "Ray"),
    ("shadow", "Ray"),
    ("sum", "Compensated"),
    ("history", "u32"),
    ("transmittance", "vec3<f32>"),
    ("light_density", "f32"),
    ("film_point", "vec2<f32>"),
    ("film_choice", "vec2<f32>"),
    ("lens_distance", "f32"),
    ("light_paths", "vec2<u32>"),
];

/// All groups of fields, in the order in which a path is loaded. Groups that only separate stages have come last.
const GROUPS: [&str; 12] = [
    "ray",
    "throughput",
    "sample_of_path",
    "run",
    "radiance",
    "direct",
    "aov_hit",
    "aov_surface",
    "aov_direct",
    "hit",
    "shadow",
    "light_weight",
];

/// The fields that kernels pass to each other. The fused kernel does not store what lies between a ray and its scattering.
pub fn path_fields(facts: &Facts, aovs: &Aovs) -> Vec<PathField> {
    all_fields(facts, aovs).into_iter().filter_map(|(field, why)| Some(PathField { why: why?, ..field })).collect()
}

/// All fields, each with its reason if the scene has it.
fn all_fields(facts: &Facts, aovs: &Aovs) -> Vec<(PathField, Option<String>)> {
    let why = |fact: &str| reason_of(facts, fact).map(Reason::to_string);
    let always = Some(Reason::EveryRender.to_string());
    // Fields that only separate stages pass on.
    let is_fused = why("fused").is_some();
    let staged = |fact| why(fact).filter(|_| !is_fused).map(|why| format!("{A_KERNEL_A_STAGE}, and {why}"));
    // Without a surface or a medium no stage needs the distance.
    let events = (!is_fused && why("event").is_some()).then(|| A_KERNEL_A_STAGE.to_string());
    let [lights, instances, mesh_lights] = ["light", "instance", "light_instance"].map(staged);
    let [probes, ratios] = ["probed", "light_paths_of_narrow_lobes"].map(staged);
    let [sampled, traced, solids] = ["sampled_light", "light_paths", "light_paths_through_solids"].map(why);
    let [aov_hit, aov_surface, aov_rough] = ["aov_hit", "aov_surface", "aov_rough"].map(why);
    let [aov_direct, aov_lights] = ["aov.direct", "aov.lights"].map(why);
    let row = |why: &Option<String>, group, name: &str, words, w_of, member: &str, code, what: &str| {
        let (name, member, what) = (name.to_string(), member.to_string(), what.to_string());
        (PathField { name, words, w_of, what, why: String::new(), group, member, code }, why.clone())
    };
    let vector =
        |why, group, name: &str, member: &str, what: &str| row(why, group, name, 3, None, member, Code::Float, what);
    let packed =
        |why, group, vector, name: &str, code, what: &str| row(why, group, name, 1, Some(vector), name, code, what);
    let word = |why, group, name: &str, code, what: &str| row(why, group, name, 1, None, name, code, what);
    use Code::{Depth, Float, Word};
    let mut all = vec![
        vector(&always, "ray", "ORIGIN", "ray.origin", "where the ray starts"),
        vector(&always, "ray", "DIRECTION", "ray.direction", "its direction"),
        packed(&always, "ray", "DIRECTION", "status", Word, "what the path is doing, or what its ray has hit"),
        vector(&always, "throughput", "THROUGHPUT", "throughput", "the factor of the light that its ray finds"),
        packed(&always, "throughput", "THROUGHPUT", "depth", Depth, "events so far, and which had narrow lobes"),
        vector(&always, "run", "SUM", "sum.sum", "radiance of the run's samples"),
        packed(&always, "run", "SUM", "rays", Word, "their rays"),
        vector(&always, "run", "EXCESS", "sum.excess", "the compensation term of that sum"),
        vector(&always, "run", "SQUARES", "squares", "squared deviations of the run's samples from their mean"),
        vector(&sampled, "radiance", "RADIANCE", "radiance", "radiance of the sample before the path's end"),
        packed(&sampled, "radiance", "RADIANCE", "pdf", Float, "density of the last scattering's direction"),
        word(&traced, "radiance", "log_ratio", Float, "logarithm of the light paths' density over the path's"),
        word(&traced, "radiance", "narrow_share", Float, "share of light paths that begin with the last event"),
        word(&traced, "radiance", "bin", Word, "the bin in which a light path's light is counted"),
        vector(&solids, "radiance", "ABSORPTION", "absorption", "what absorbs the ray of a light path"),
        vector(&aov_direct, "direct", "DIRECT", "direct", "direct radiance of the sample so far"),
        vector(&lights, "shadow", "SHADOW_ORIGIN", "shadow.origin", "where the ray to a light starts"),
        packed(&lights, "shadow", "SHADOW_ORIGIN", "light", Word, "the light"),
        vector(&lights, "shadow", "SHADOW_DIRECTION", "shadow.direction", "the direction of that ray"),
        vector(&lights, "light_weight", "LIGHT_WEIGHT", "light_weight", "its contribution per radiance of the light"),
        packed(&probes, "light_weight", "LIGHT_WEIGHT", "probe", Float, "its weight as a probe for narrow lobes"),
        word(&ratios, "light_weight", "light_ratio", Float, "logarithm of the light paths' density over its own"),
        word(&events, "hit", "t", Float, "distance to what the ray has hit"),
        word(&always, "run", "counts", Word, "samples of the run, accepted and rejected"),
        word(&always, "sample_of_path", "pixel", Word, "the pixel"),
        word(&always, "sample_of_path", "sample", Word, "the sample of the pixel"),
        word(&aov_rough, "aov_surface", "seen", Word, "whether the sample's albedo and normal are known"),
        word(&instances, "hit", "instance", Word, "the mesh's instance, or the side of the body, that was hit"),
        word(&mesh_lights, "shadow", "light_instance", Word, "the instance whose mesh the light is a face of"),
    ];
    for group in 0..aovs.groups().len() {
        let (name, member) = (format!("LIGHT_OF_{group}"), format!("{LIGHT}[{group}]"));
        all.push(vector(&aov_lights, "direct", &name, &member, "radiance of the sample so far, by a group of lights"));
    }
    for (index, (group, name)) in (aovs.plain_count()..).zip(aovs.light_components()) {
        let what = format!("sum of light group {group} over the run's samples");
        let field = format!("sum_of_{}", name.replace('.', "_"));
        all.push(row(&aov_lights, "aov_direct", &field, 1, None, &format!("{AOV}[{index}]"), Float, &what));
    }
    for (index, (sum, name)) in aovs.sum_components().enumerate() {
        let (why, group) = match sum.finder() {
            Finder::Hit => (&aov_hit, "aov_hit"),
            Finder::Surface => (&aov_surface, "aov_surface"),
            Finder::Direct => (&aov_direct, "aov_direct"),
        };
        let what = format!("sum of {name} over the run's samples");
        let field = format!("sum_of_{}", name.replace('.', "_"));
        all.push(row(why, group, &field, 1, None, &format!("{AOV}[{index}]"), Float, &what));
    }
    all
}

/// The module `generated/path`: the struct of a path. It has all members; unused ones cost a kernel nothing.
pub fn path_module(aovs: &Aovs) -> String {
    let mut members: Vec<(String, String)> =
        OTHER_MEMBERS.iter().map(|(name, kind)| (name.to_string(), kind.to_string())).collect();
    for (field, _) in all_fields(&Facts::new(), aovs) {
        let has = |name: &str| members.iter().any(|(member, _)| member == name);
        if has(field.member.split('.').next().unwrap_or_default()) || field.member.contains('[') {
            continue;
        }
        let kind = match (field.words, field.code) {
            (3, _) => "vec3<f32>",
            (_, Code::Float) => "f32",
            _ => "u32",
        };
        members.push((field.member, kind.to_string()));
    }
    // WGSL has no empty arrays.
    members.push((AOV.to_string(), format!("array<f32, {}>", aovs.count().max(1))));
    if !aovs.groups().is_empty() {
        members.push((LIGHT.to_string(), format!("array<vec3<f32>, {}>", aovs.groups().len())));
    }
    let members: String = members.iter().map(|(name, kind)| format!("    {name}: {kind},\n")).collect();
    format!("struct Path {{\n{members}}}\n")
}

/// The module `generated/slots`: for each group of fields, a function that loads them and one that stores them. A word that shares a vec4
/// with a vector also has functions of its own.
pub fn slots_module(fields: &[PathField]) -> String {
    let mut text = String::from("//@ use slots/memory\n//@ use choice/probe\n");
    for group in GROUPS {
        let (mut load, mut store) = (String::new(), String::new());
        for field in fields.iter().filter(|field| field.group == group && field.w_of.is_none()) {
            let PathField { name, member, words, .. } = field;
            if *words == 1 {
                let _ = writeln!(load, "    {}", field.taken_from(&format!("load_{name}(slot)")));
                let _ = writeln!(store, "    store_{name}(slot, {});", field.as_word());
                continue;
            }
            let _ = writeln!(load, "    let words_of_{name} = paths[index_of(PLANE_OF_{name}, slot)];");
            let _ = writeln!(load, "    (*path).{member} = vector_of(words_of_{name});");
            let last = fields.iter().find(|other| other.w_of == Some(name.as_str()));
            let _ = match last {
                Some(last) => {
                    let _ = writeln!(load, "    {}", last.taken_from(&format!("words_of_{name}.w")));
                    let word = last.as_word();
                    writeln!(store, "    store_plane(PLANE_OF_{name}, slot, (*path).{member}, {word});")
                }
                None => writeln!(store, "    store_vector(PLANE_OF_{name}, slot, (*path).{member});"),
            };
        }
        for (verb, body) in [("load", load), ("store", store)] {
            let _ = write!(text, "\nfn {verb}_{group}(slot: u32, path: ptr<function, Path>) {{\n{body}}}\n");
        }
    }
    for PathField { name, w_of, .. } in fields {
        if let Some(vector) = w_of {
            let _ = write!(
                text,
                "\nfn load_{name}(slot: u32) -> u32 {{\n    return paths[index_of(PLANE_OF_{vector}, slot)].w;\n}}\n\n\
                 fn store_{name}(slot: u32, word: u32) {{\n    paths[index_of(PLANE_OF_{vector}, slot)].w = word;\n}}\n"
            );
        }
    }
    text
}

/// The layout of the fields: names and numbers.
#[derive(Clone, Debug, Default)]
pub struct PathLayout {
    /// Vectors, by plane.
    pub planes: Vec<(String, u32)>,
    /// Words in planes: four times the plane, and the component.
    pub words: Vec<(String, u32)>,
    /// Words outside the planes.
    pub others: Vec<(String, u32)>,
}

/// Vectors have a plane each. Words that are not packed with a vector first fill the fourth words of vectors without one, then planes of
/// four words. The last ones, which fill no plane, lie in a separate buffer.
pub fn path_layout(fields: &[PathField]) -> PathLayout {
    let vectors: Vec<&PathField> = fields.iter().filter(|field| field.words > 1).collect();
    let alone = |vector: &&PathField| !fields.iter().any(|field| field.w_of == Some(vector.name.as_str()));
    let free: Vec<u32> =
        (0..).zip(&vectors).filter(|(_, vector)| alone(vector)).map(|(plane, _)| plane * 4 + 3).collect();
    let loose = fields.iter().filter(|field| field.words == 1 && field.w_of.is_none());
    let mut loose = loose.map(|field| field.name.clone());
    let mut words: Vec<_> = free.into_iter().zip(loose.by_ref()).map(|(word, name)| (name, word)).collect();
    let rest: Vec<String> = loose.collect();
    let (full, others) = rest.split_at(rest.len() / 4 * 4);
    words.extend(full.iter().cloned().zip(vectors.len() as u32 * 4..));
    PathLayout {
        planes: vectors.iter().map(|vector| vector.name.clone()).zip(0..).collect(),
        words,
        others: others.iter().cloned().zip(0..).collect(),
    }
}

impl PathLayout {
    /// Bytes of a slot's planes. They are more than the fields' if some fourth word is unused.
    pub fn plane_bytes(&self) -> u64 {
        let planes = self.words.iter().map(|(_, word)| word / 4 + 1);
        16 * u64::from(planes.max().unwrap_or(0).max(self.planes.len() as u32))
    }

    /// Bytes of a slot's words outside the planes.
    pub fn word_bytes(&self) -> u64 {
        4 * self.others.len() as u64
    }
}

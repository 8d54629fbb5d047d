//! What slots keep of their paths from one dispatch to the next: just the fields that the kernels of a scene hand to each other, and where
//! they lie.

use super::A_KERNEL_A_STAGE;
use super::choices::Conditions;
use crate::aov::Aovs;
use crate::gpu::link::Reason;

/// A field of the paths' state: words of 32 bits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PathField {
    /// As `shaders/slots` spells it.
    pub name: &'static str,
    pub words: u32,
    /// The vector that it stands behind, where the two are read and written as one.
    pub behind: Option<&'static str>,
    pub what: &'static str,
    /// What asked for it.
    pub why: String,
}

impl PathField {
    /// "shadow origin" of shadow_origin.
    pub fn label(&self) -> String {
        self.name.to_lowercase().replace('_', " ")
    }

    pub fn bytes(&self) -> u64 {
        u64::from(self.words) * 4
    }

    /// Whether a kernel that has declarations of these names reads or writes it.
    pub fn is_used(&self, has: impl Fn(&str) -> bool) -> bool {
        match (self.words, self.behind) {
            (1, None) => has(&format!("load_{}", self.name)) || has(&format!("store_{}", self.name)),
            _ => has(&format!("PLANE_OF_{}", self.behind.unwrap_or(self.name))),
        }
    }
}

/// The most bytes that they are, of any scene: without channels beside the radiance, and what these add.
const MOST_PATH_BYTES: u64 = 168;
const MOST_BYTES_OF_AOVS: u64 = 80;

/// The most bytes that they are, of any scene with these channels.
pub fn most_path_bytes(aovs: &Aovs) -> u64 {
    MOST_PATH_BYTES + if aovs.is_empty() { 0 } else { MOST_BYTES_OF_AOVS }
}

/// The fields that kernels hand to each other. The fused kernel keeps to itself what lies between a ray and its scattering.
pub fn path_fields(conditions: &Conditions, fused: bool) -> Vec<PathField> {
    let words = |why: &Option<Reason>| why.as_ref().map(Reason::to_string);
    let always = words(&Some(Reason::EveryRender));
    let gathers = words(&conditions.gathers);
    // What only stages that are kernels of their own hand on: for all scenes, or beside that for what some of them ask.
    let staged = |why| words(why).filter(|_| !fused).map(|why| format!("{A_KERNEL_A_STAGE}, and {why}"));
    let (staged_lights, staged_meshes, staged_mesh_lights) =
        (staged(&conditions.light), staged(&conditions.mesh), staged(&conditions.emitting_mesh));
    let staged_probes = staged(&conditions.probed);
    // Without a surface or a medium nobody asks how far it is.
    let staged_events = (!fused && conditions.event.is_some()).then(|| A_KERNEL_A_STAGE.to_string());
    let field = |why: &Option<String>, name, words, behind, what| {
        Some(PathField { name, words, behind, what, why: why.clone()? })
    };
    let vector = |why, name, what| field(why, name, 3, None, what);
    let behind = |why, vector, name, what| field(why, name, 1, Some(vector), what);
    let word = |why, name, what| field(why, name, 1, None, what);
    let all = [
        vector(&always, "ORIGIN", "where the ray starts"),
        vector(&always, "DIRECTION", "its direction"),
        behind(&always, "DIRECTION", "status", "what the path is doing, or what its ray has met"),
        vector(&always, "THROUGHPUT", "the share of the light met next that reaches the camera"),
        behind(&always, "THROUGHPUT", "depth", "scattering events so far, and which of them had narrow lobes"),
        vector(&always, "SUM", "radiance of the run's samples"),
        behind(&always, "SUM", "rays", "their rays"),
        vector(&always, "EXCESS", "what that sum is too large by, of its roundings"),
        vector(&always, "SPREAD", "squared deviations of the run's samples from their mean"),
        vector(
            &gathers,
            "RADIANCE",
            "radiance of the sample so far, by lights that were sampled and surfaces that emit and scatter",
        ),
        behind(&gathers, "RADIANCE", "pdf", "density of the last scattering's direction"),
        vector(&words(&conditions.aov_direct), "DIRECT", "direct radiance of the sample so far"),
        vector(&words(&conditions.aov_direct), "DIRECT_SUM", "that of the run's samples"),
        vector(&words(&conditions.aov_albedo), "ALBEDO_SUM", "albedos of the run's samples"),
        vector(&words(&conditions.aov_normal), "NORMAL_SUM", "their normals"),
        vector(&words(&conditions.aov_position), "POSITION_SUM", "their positions"),
        vector(&staged_lights, "SHADOW_ORIGIN", "where the ray to a light starts"),
        behind(&staged_lights, "SHADOW_ORIGIN", "light", "the light"),
        vector(&staged_lights, "SHADOW_DIRECTION", "the direction of that ray"),
        vector(&staged_lights, "LIGHT_WEIGHT", "what the light brings per radiance, if nothing is in its way"),
        behind(&staged_probes, "LIGHT_WEIGHT", "probe", "the weight of that ray as a probe for light of narrow lobes"),
        word(&staged_events, "t", "distance to what the ray has met"),
        word(&always, "counts", "samples of the run, accepted and rejected"),
        word(&always, "pixel", "the pixel"),
        word(&always, "sample", "the sample of the pixel"),
        word(&words(&conditions.aov_hits), "hits", "samples of the run whose camera ray hits a surface"),
        word(&words(&conditions.aov_depth), "depth_sum", "their depths"),
        word(&words(&conditions.aov_object), "object", "the object that the pixel's first sample hits"),
        word(&words(&conditions.aov_material), "material", "the material of that object"),
        word(&words(&conditions.aov_rough), "seen", "whether the albedo and the normal of the sample are known"),
        word(&staged_meshes, "instance", "the mesh that the ray has met a part of"),
        word(&staged_mesh_lights, "light_instance", "the mesh that the light is part of"),
    ];
    all.into_iter().flatten().collect()
}

/// Where the fields lie: names and numbers.
#[derive(Clone, Debug, Default)]
pub struct Places {
    /// Vectors, by plane.
    pub planes: Vec<(&'static str, u32)>,
    /// Words in planes: four times the plane, and the component.
    pub words: Vec<(&'static str, u32)>,
    /// Words beside the planes.
    pub others: Vec<(&'static str, u32)>,
}

/// Vectors have a plane each. Words without a vector of their own stand behind those that have none, then four to a plane; what is left
/// fills no plane.
pub fn places(fields: &[PathField]) -> Places {
    let vectors: Vec<&PathField> = fields.iter().filter(|field| field.words > 1).collect();
    let alone = |vector: &&PathField| !fields.iter().any(|field| field.behind == Some(vector.name));
    let free: Vec<u32> =
        (0..).zip(&vectors).filter(|(_, vector)| alone(vector)).map(|(plane, _)| plane * 4 + 3).collect();
    let mut loose = fields.iter().filter(|field| field.words == 1 && field.behind.is_none()).map(|field| field.name);
    let mut words: Vec<_> = free.into_iter().zip(loose.by_ref()).map(|(place, name)| (name, place)).collect();
    let rest: Vec<&'static str> = loose.collect();
    let (full, others) = rest.split_at(rest.len() / 4 * 4);
    words.extend(full.iter().copied().zip(vectors.len() as u32 * 4..));
    Places {
        planes: vectors.iter().map(|vector| vector.name).zip(0..).collect(),
        words,
        others: others.iter().copied().zip(0..).collect(),
    }
}

impl Places {
    /// Bytes of a slot's planes: more than their fields, where vectors without a companion are more than the words that are left.
    pub fn plane_bytes(&self) -> u64 {
        let planes = self.words.iter().map(|(_, place)| place / 4 + 1);
        16 * u64::from(planes.max().unwrap_or(0).max(self.planes.len() as u32))
    }

    /// Bytes of a slot's words beside the planes.
    pub fn word_bytes(&self) -> u64 {
        4 * self.others.len() as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each vector and word has a place of its own within the bytes that a slot is given, however many there are of either.
    #[test]
    fn every_field_has_a_place_of_its_own() {
        let names = ["a", "b", "c", "d", "e", "f", "g", "h", "i", "j"];
        for vectors in 0..5 {
            for words in 0..10 {
                let field = |name, words| PathField { name, words, behind: None, what: "", why: String::new() };
                let vectors_of = ["A", "B", "C", "D"].into_iter().take(vectors).map(|name| field(name, 3));
                let fields: Vec<_> =
                    vectors_of.chain(names.into_iter().take(words).map(|name| field(name, 1))).collect();
                let places = places(&fields);
                let of_vectors = places.planes.iter().flat_map(|(_, plane)| (0..3).map(move |i| 4 * plane + i));
                let mut taken: Vec<u32> = of_vectors.chain(places.words.iter().map(|(_, place)| *place)).collect();
                assert!(taken.iter().all(|place| u64::from(*place) * 4 < places.plane_bytes()), "{places:?}");
                taken.sort_unstable();
                taken.dedup();
                assert_eq!(taken.len() + places.others.len(), 3 * vectors + words, "{places:?}");
            }
        }
    }
}

//! Channels of `--aov` (arbitrary output variables, AOVs): which there are, which sums of the film they are made of, and how files
//! name them.

mod mattes;

use clap::ValueEnum;
use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

use crate::data::CHANNELS;
pub use mattes::{MATTE_ATTRIBUTES, MatteKind, MatteValue, id_of};

/// The group of the background.
pub const BACKGROUND: &str = "background";
/// The layer of the light without a group is named as if this were its group.
pub const REST: &str = "rest";

/// A channel, or three.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub enum Aov {
    /// The share of light that a surface scatters.
    Albedo,
    /// The shading normal in the axes of the world.
    Normal,
    /// The distance to the first surface along the camera's axis, in scene units.
    Depth,
    /// The point where camera rays hit the first surface, in scene units.
    Position,
    /// The number of the object there.
    Object,
    /// The number of its material.
    Material,
    /// The radiance of light seen directly, and of light on the first surface or medium.
    Direct,
    /// The rest of the radiance.
    Indirect,
    /// How far the surface of sample 0 moves on the image until the next frame, in pixels.
    Motion,
    /// Of sample 0: the distance to the first surface along the camera's axis, in scene units.
    Depth0,
    /// That distance along the ray.
    Distance0,
    /// The point.
    Position0,
    /// The shading normal there.
    Normal0,
    /// The texture coordinates there.
    Uv0,
    /// The number of the mesh's face there.
    Face0,
    /// Where in the pixel sample 0 is, in pixels from the pixel's left upper corner.
    Offset0,
    /// The radiance of each group of lights, and of the lights without a group.
    Lights,
    /// Mattes of objects and materials.
    Cryptomatte,
    /// Mattes of assets.
    Cryptoasset,
}

/// The channels of sample 0. Their values are stored, each in a word of 32 bits: a mean over samples would blend surfaces at edges. Each has its
/// name in the kernels, and the components that kernels store of it.
const STORED: [(Aov, &str, &[&str]); 8] = [
    // What the host needs to follow the surface to the frames around.
    (Aov::Motion, "seen0", &["seen0.at.x", "seen0.at.y", "seen0.at.z", "seen0.object", "seen0.face", "seen0.time"]),
    (Aov::Depth0, "depth0", &["depth0"]),
    (Aov::Distance0, "distance0", &["distance0"]),
    (Aov::Position0, "position0", &["position0.x", "position0.y", "position0.z"]),
    (Aov::Normal0, "normal0", &["normal0.x", "normal0.y", "normal0.z"]),
    (Aov::Uv0, "uv0", &["uv0.x", "uv0.y"]),
    (Aov::Face0, "face0", &["face0"]),
    (Aov::Offset0, "offset0", &["offset0.x", "offset0.y"]),
];

/// The words that the film has of a stored channel: as many as kernels store, but of a motion those of [`crate::flatten::Neighbours`].
fn words_on_film((aov, _, of_kernels): (Aov, &str, &[&str])) -> usize {
    if aov == Aov::Motion { 4 } else { of_kernels.len() }
}

/// Of which surface the albedo and the normal are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum SeenSurface {
    /// Mirrors and clear glass are passed.
    #[default]
    Rough,
    /// The first one.
    First,
}

/// How an image file names the channels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum ChannelNames {
    #[default]
    Plain,
    /// As the passes of Blender's multilayer files.
    Blender,
}

/// The channels of `--aov` of a render.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Aovs {
    /// In their order, each once.
    list: Vec<Aov>,
    pub surface: SeenSurface,
    pub names: ChannelNames,
    /// The groups of lights of the scene, in order; none without [`Aov::Lights`].
    groups: Vec<String>,
}

/// What the film sums up for them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sum {
    Albedo,
    Normal,
    /// Camera rays that hit a surface.
    Hits,
    Depth,
    Position,
    Object,
    Material,
    Direct,
}

/// The step of the kernels that finds what a sum adds up, under shaders/aov.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Finder {
    /// The first surface that camera rays hit.
    Hit,
    /// The surface that is seen, past mirrors and clear glass or not.
    Surface,
    /// Light seen directly, and light on the first surface or medium.
    Direct,
}

impl Sum {
    const ALL: [Sum; 8] =
        [Sum::Albedo, Sum::Normal, Sum::Hits, Sum::Depth, Sum::Position, Sum::Object, Sum::Material, Sum::Direct];

    /// Its name, the names of its components, its step, and the channels that are made of it.
    fn declared(self) -> (&'static str, &'static [&'static str], Finder, &'static [Aov]) {
        match self {
            Sum::Albedo => ("albedo", &CHANNELS, Finder::Surface, &[Aov::Albedo]),
            Sum::Normal => ("normal", &["X", "Y", "Z"], Finder::Surface, &[Aov::Normal]),
            Sum::Hits => ("hits", &["Y"], Finder::Hit, &[Aov::Depth, Aov::Position]),
            Sum::Depth => ("depth", &["Y"], Finder::Hit, &[Aov::Depth]),
            Sum::Position => ("position", &["X", "Y", "Z"], Finder::Hit, &[Aov::Position]),
            Sum::Object => ("object", &["Y"], Finder::Hit, &[Aov::Object]),
            Sum::Material => ("material", &["Y"], Finder::Hit, &[Aov::Material]),
            Sum::Direct => ("direct", &CHANNELS, Finder::Direct, &[Aov::Direct, Aov::Indirect]),
        }
    }

    pub fn name(self) -> &'static str {
        self.declared().0
    }

    /// Its components, as names.
    pub fn components(self) -> &'static [&'static str] {
        self.declared().1
    }

    pub fn finder(self) -> Finder {
        self.declared().2
    }
}

/// The sums of a group of lights on the film: even and odd runs, and their light paths.
pub fn sums_of_group(light_paths: bool) -> usize {
    CHANNELS.len() * if light_paths { 4 } else { 2 }
}

/// How the layers of groups of lights begin, and how Blender's do.
const LIGHT_LAYERS: [&str; 2] = ["light_", "Combined_"];

/// The group whose light a layer has.
pub fn group_of_layer(layer: &str) -> Option<&str> {
    LIGHT_LAYERS.iter().find_map(|begin| layer.strip_prefix(begin))
}

/// A channel of an image file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    pub aov: Aov,
    /// The index. The components of one group of lights follow those of another, and those of the rest are last.
    pub component: usize,
    pub name: String,
}

impl Aov {
    /// How users name it.
    fn word(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }
}

impl Aovs {
    /// Channels by their names, with commas between.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn parse(text: &str) -> Result<Vec<Aov>, String> {
        let known = || Aov::value_variants().iter().map(|aov| aov.word()).collect::<Vec<_>>().join(", ");
        let aov = |word: &str| {
            Aov::from_str(word.trim(), false).map_err(|_| format!("expected some of {}, found `{word}`", known()))
        };
        text.split(',').map(aov).collect()
    }

    /// Sets which channels there are.
    pub fn set(&mut self, mut list: Vec<Aov>) {
        list.sort_unstable();
        list.dedup();
        self.list = list;
    }

    /// The channels of a scene with these groups of lights.
    pub fn of_groups(&self, groups: &[String]) -> Aovs {
        Aovs { groups: if self.has(Aov::Lights) { groups.to_vec() } else { Vec::new() }, ..self.clone() }
    }

    /// The groups of lights that have sums.
    pub fn groups(&self) -> &[String] {
        &self.groups
    }

    /// Adds channels to those that there are.
    pub fn include(&mut self, more: &[Aov]) {
        self.set([&self.list[..], more].concat());
    }

    /// Their names with commas between; nothing where there are none.
    pub fn words(&self) -> Option<String> {
        let words = Aov::value_variants().iter().filter(|aov| self.has(**aov)).map(|aov| aov.word());
        (!self.list.is_empty()).then(|| words.collect::<Vec<_>>().join(","))
    }

    /// The channels of a film, or the default if it has none: how they would be written does not matter then.
    pub fn of_film(&self) -> Aovs {
        if self.is_empty() { Aovs::default() } else { self.clone() }
    }

    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    pub fn has(&self, aov: Aov) -> bool {
        self.list.contains(&aov)
    }

    /// Whether the film sums this up.
    pub fn needs(&self, sum: Sum) -> bool {
        sum.declared().3.iter().any(|aov| self.has(*aov))
    }

    pub fn sums(&self) -> impl Iterator<Item = Sum> {
        Sum::ALL.into_iter().filter(|sum| self.needs(*sum))
    }

    /// How many sums there are without those of lights, by components.
    pub fn plain_count(&self) -> usize {
        self.sums().map(|sum| sum.components().len()).sum()
    }

    /// How many sums a run has, by components: those of lights are the last.
    pub fn count(&self) -> usize {
        self.plain_count() + CHANNELS.len() * self.groups.len()
    }

    /// How many sums a pixel has.
    pub fn count_on_film(&self, light_paths: bool) -> usize {
        self.plain_count() + sums_of_group(light_paths) * self.groups.len()
    }

    /// The sums of lights of a run, each with the number of its group and its name.
    pub fn light_components(&self) -> impl Iterator<Item = (usize, String)> {
        let of_group = |group| CHANNELS.map(|channel| (group, format!("light_of_{group}.{channel}")));
        (0..self.groups.len()).flat_map(of_group)
    }

    /// The names of the sums of a pixel. Even and odd runs have sums of lights of their own, and so have their light paths.
    pub fn names_on_film(&self, light_paths: bool) -> impl Iterator<Item = String> {
        let plain = self.sum_components().map(|(_, name)| name);
        let parts =
            ["even", "odd", "light_even", "light_odd"].into_iter().take(sums_of_group(light_paths) / CHANNELS.len());
        let of_group = move |group: &String| {
            let name = format!("{}{group}", LIGHT_LAYERS[0]);
            let of_part = move |part: &'static str| CHANNELS.map(|channel| format!("{name}.{part}.{channel}"));
            parts.clone().flat_map(of_part)
        };
        plain.chain(self.groups.iter().flat_map(of_group))
    }

    /// The index of a sum's first component; `None` if the film does not have the sum.
    pub fn first_sum(&self, sum: Sum) -> Option<usize> {
        let before = self.sums().take_while(|other| *other != sum).map(|sum| sum.components().len()).sum();
        self.needs(sum).then_some(before)
    }

    /// The sums by components: each with its name, `albedo.R`.
    pub fn sum_components(&self) -> impl Iterator<Item = (Sum, String)> {
        self.sums().flat_map(|sum| sum.components().iter().map(move |name| (sum, format!("{}.{name}", sum.name()))))
    }

    /// The channels of sample 0, each with its name in the kernels and the components that they store of it.
    pub fn stored(&self) -> impl Iterator<Item = (Aov, &'static str, &'static [&'static str])> {
        STORED.into_iter().filter(|(aov, ..)| self.has(*aov))
    }

    /// The words that kernels store of sample 0 of a pixel, as expressions of the kernel `truth`.
    pub fn words_of_kernels(&self) -> Vec<&'static str> {
        self.stored().flat_map(|(_, _, words)| words).copied().collect()
    }

    /// The names of the words that the film has of sample 0 of a pixel.
    pub fn words_on_film(&self) -> Vec<String> {
        let names = |stored: (Aov, &'static str, &'static [&'static str])| {
            (0..words_on_film(stored)).map(move |number| format!("{}.{number}", stored.1))
        };
        self.stored().flat_map(names).collect()
    }

    /// The index of the first of them that belongs to a channel.
    pub fn first_word(&self, aov: Aov) -> usize {
        self.stored().take_while(|(other, ..)| *other != aov).map(words_on_film).sum()
    }

    /// The channels of an image file.
    pub fn channels(&self) -> Vec<Channel> {
        let of_aov = |aov: &Aov| {
            let (layer, components) = self.layer(*aov);
            let name = move |component: &&str| match layer {
                "" => (*component).to_string(),
                layer => format!("{layer}.{component}"),
            };
            let channel = |(component, name): (usize, String)| Channel { aov: *aov, component, name };
            components.iter().map(name).enumerate().map(channel).collect::<Vec<_>>()
        };
        self.list.iter().flat_map(of_aov).chain(self.light_channels()).chain(self.matte_channels()).collect()
    }

    /// The channels of groups of lights in an image file, and those of the rest.
    fn light_channels(&self) -> impl Iterator<Item = Channel> {
        let before = LIGHT_LAYERS[self.names as usize];
        let rest = self.has(Aov::Lights).then_some(REST);
        let groups = self.groups.iter().map(String::as_str).chain(rest);
        let names = groups.flat_map(move |group| CHANNELS.map(|channel| format!("{before}{group}.{channel}")));
        names.enumerate().map(|(component, name)| Channel { aov: Aov::Lights, component, name })
    }

    /// The layer of a channel, and its components.
    fn layer(&self, aov: Aov) -> (&'static str, &'static [&'static str]) {
        const XYZ: &[&str] = &["X", "Y", "Z"];
        match (self.names, aov) {
            (ChannelNames::Plain, Aov::Albedo) => ("albedo", &CHANNELS),
            (ChannelNames::Plain, Aov::Normal) => ("N", XYZ),
            (ChannelNames::Plain, Aov::Depth) => ("", &["Z"]),
            (ChannelNames::Plain, Aov::Position) => ("P", XYZ),
            (ChannelNames::Plain, Aov::Object) => ("object", &["Y"]),
            (ChannelNames::Plain, Aov::Material) => ("material", &["Y"]),
            (ChannelNames::Blender, Aov::Albedo) if self.surface == SeenSurface::Rough => {
                ("Denoising Albedo", &CHANNELS)
            }
            (ChannelNames::Blender, Aov::Albedo) => ("DiffCol", &CHANNELS),
            (ChannelNames::Blender, Aov::Normal) if self.surface == SeenSurface::Rough => ("Denoising Normal", XYZ),
            (ChannelNames::Blender, Aov::Normal) => ("Normal", XYZ),
            (ChannelNames::Blender, Aov::Depth) => ("Depth", &["Z"]),
            (ChannelNames::Blender, Aov::Position) => ("Position", XYZ),
            (ChannelNames::Blender, Aov::Object) => ("IndexOB", &["X"]),
            (ChannelNames::Blender, Aov::Material) => ("IndexMA", &["X"]),
            (_, Aov::Direct) => ("direct", &CHANNELS),
            (_, Aov::Indirect) => ("indirect", &CHANNELS),
            (ChannelNames::Plain, Aov::Motion) => ("motion", &["X", "Y"]),
            (ChannelNames::Blender, Aov::Motion) => ("Vector", &["X", "Y", "Z", "W"]),
            (_, Aov::Depth0) => ("depth0", &["Z"]),
            (_, Aov::Distance0) => ("distance0", &["Z"]),
            (_, Aov::Position0) => ("position0", XYZ),
            (_, Aov::Normal0) => ("normal0", XYZ),
            (_, Aov::Uv0) => ("uv0", &["U", "V"]),
            (_, Aov::Face0) => ("face0", &["Y"]),
            (_, Aov::Offset0) => ("offset0", &["X", "Y"]),
            // They have several layers.
            (_, Aov::Lights | Aov::Cryptomatte | Aov::Cryptoasset) => ("", &[]),
        }
    }
}

/// From render space, in which the kernels measure lengths and directions, to the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneSpace {
    /// The camera, in scene units.
    pub eye: DVec3,
    /// The axes of render space, in the world's.
    pub axes: DMat3,
    /// A length of the scene is that of render space times 2 to this power.
    pub exponent: i32,
}

impl SceneSpace {
    pub fn length(&self, length: f64) -> f64 {
        length * 2f64.powi(self.exponent)
    }

    pub fn direction(&self, direction: DVec3) -> DVec3 {
        self.axes * direction
    }

    pub fn point(&self, point: DVec3) -> DVec3 {
        self.eye + self.axes * (point * 2f64.powi(self.exponent))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_and_written_in_one_order() {
        let mut aovs = Aovs::default();
        assert_eq!(aovs.words(), None);
        aovs.set(Aovs::parse("depth, albedo,depth").unwrap());
        assert_eq!(aovs.words().as_deref(), Some("albedo,depth"));
        aovs.include(&[Aov::Normal, Aov::Albedo]);
        assert_eq!(aovs.words().as_deref(), Some("albedo,normal,depth"));
        let message = Aovs::parse("albedo,colour").unwrap_err();
        assert!(message.contains("`colour`") && message.contains("albedo, normal, depth, position"), "{message}");
        assert!(Aovs::parse("").is_err());
    }

    /// The sums follow one another without a gap, whatever channels are requested.
    #[test]
    fn no_two_sums_overlap() {
        for set in 0..1 << Aov::value_variants().len() {
            let requested = Aov::value_variants()
                .iter()
                .enumerate()
                .filter(|(number, _)| set >> number & 1 == 1)
                .map(|(_, aov)| *aov);
            let mut aovs = Aovs::default();
            aovs.set(requested.collect());
            let names: Vec<String> = aovs.sum_components().map(|(_, name)| name).collect();
            assert_eq!(names.len(), aovs.count());
            for sum in Sum::ALL {
                match aovs.first_sum(sum) {
                    Some(first) => assert!(names[first].starts_with(sum.name()), "{names:?}"),
                    None => assert!(!names.iter().any(|name| name.starts_with(sum.name())), "{names:?}"),
                }
            }
            let words = aovs.words_on_film();
            for stored in aovs.stored() {
                assert!(words[aovs.first_word(stored.0)].starts_with(stored.1), "{words:?}");
            }
            // With the nine of every film, a bit each shows which has left its range. The last bit is left to what follows, which may share it.
            assert!(9 + aovs.plain_count() < 32);
        }
    }
}

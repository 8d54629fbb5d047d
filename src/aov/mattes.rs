//! The mattes of Cryptomatte 1.2.0 (J. Friedman and A. C. Jones, "Fully automatic ID mattes with support for motion blur and transparency",
//! SIGGRAPH 2015, and Psyop's "Cryptomatte Specification"): of which names a pixel sees how much.

use std::collections::BTreeMap;

use serde_json::Value;

use super::{Aov, Aovs, Channel, ChannelNames};
use crate::data::MATTE_WORDS;

/// The kinds of mattes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MatteKind {
    Object,
    Material,
    /// The topmost node of a glTF file's hierarchy, or the outermost name.
    Asset,
}

/// The names in a file of the ids that a pixel sees the most of, and of their shares: two in each layer.
const RANKS: usize = 6;
/// Channels of a kind: an id and a share for each rank.
const OF_KIND: usize = 2 * RANKS;
/// How the names of the attributes of mattes begin.
pub const MATTE_ATTRIBUTES: &str = "cryptomatte/";
/// The layer with the samples that no matte has.
const LOST: &str = "crypto_lost";

impl MatteKind {
    const ALL: [MatteKind; 3] = [MatteKind::Object, MatteKind::Material, MatteKind::Asset];

    /// The name of its mattes in files.
    pub fn name(self) -> &'static str {
        match self {
            MatteKind::Object => "CryptoObject",
            MatteKind::Material => "CryptoMaterial",
            MatteKind::Asset => "CryptoAsset",
        }
    }
}

/// The value of a channel of mattes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MatteValue {
    /// The id of this rank, from 0, of the kind of this index.
    Id(usize, usize),
    /// The share of the pixel that an id has.
    Share(usize, usize),
    /// The camera samples that no matte has.
    Lost,
}

impl Aovs {
    /// The kinds of mattes.
    pub fn mattes(&self) -> &'static [MatteKind] {
        match (self.has(Aov::Cryptomatte), self.has(Aov::Cryptoasset)) {
            (true, true) => &MatteKind::ALL,
            (true, false) => &MatteKind::ALL[..2],
            (false, true) => &MatteKind::ALL[2..],
            (false, false) => &[],
        }
    }

    /// Adds the mattes of assets to those of a glTF file's objects.
    pub fn complete(&mut self, is_gltf: bool) {
        if is_gltf && self.has(Aov::Cryptomatte) {
            self.include(&[Aov::Cryptoasset]);
        }
    }

    /// The words that kernels and the film have of a pixel's mattes.
    pub fn matte_words(&self) -> usize {
        self.mattes().len() * MATTE_WORDS as usize
    }

    /// The name of a kind's layers, without their numbers. The attributes have it, too.
    fn matte_layer(&self, kind: MatteKind) -> String {
        match self.names {
            ChannelNames::Plain => kind.name().to_owned(),
            ChannelNames::Blender => format!("ViewLayer.{}", kind.name()),
        }
    }

    /// Whether the name of a channel has that of Blender's view layer already.
    pub fn is_full_name(&self, channel: &Channel) -> bool {
        channel.aov == Aov::Cryptomatte && self.matte_value(channel.component) != MatteValue::Lost
    }

    /// The channels of mattes in an image file.
    pub(super) fn matte_channels(&self) -> impl Iterator<Item = Channel> {
        let letters = if self.names == ChannelNames::Blender { ["r", "g", "b", "a"] } else { ["R", "G", "B", "A"] };
        let of_kind = move |kind: &MatteKind| {
            let layer = self.matte_layer(*kind);
            let channel = |number: usize| format!("{layer}{:02}.{}", number / 4, letters[number % 4]);
            (0..OF_KIND).map(channel).collect::<Vec<_>>()
        };
        let lost = (!self.mattes().is_empty()).then(|| format!("{LOST}.Y"));
        let names = self.mattes().iter().flat_map(of_kind).chain(lost);
        names.enumerate().map(|(component, name)| Channel { aov: Aov::Cryptomatte, component, name })
    }

    /// The contents of a channel of mattes, by the index of its component.
    pub fn matte_value(&self, component: usize) -> MatteValue {
        let (kind, rank) = (component / OF_KIND, component % OF_KIND / 2);
        match component % 2 {
            _ if kind >= self.mattes().len() => MatteValue::Lost,
            0 => MatteValue::Id(kind, rank),
            _ => MatteValue::Share(kind, rank),
        }
    }

    /// The attributes of a file that name the ids of its mattes. `names` has those of each kind.
    pub fn matte_attributes(&self, names: &[Vec<String>]) -> Vec<(String, String)> {
        let of_kind = |(kind, names): (&MatteKind, &Vec<String>)| {
            let layer = self.matte_layer(*kind);
            let ids: BTreeMap<&str, String> =
                names.iter().map(|name| (name.as_str(), format!("{:08x}", id_of(name)))).collect();
            let manifest = Value::from_iter(ids.into_iter().map(|(name, id)| (name, Value::from(id)))).to_string();
            let key = format!("{:08x}", hash_of(&layer));
            let attribute = |(name, value)| (format!("{MATTE_ATTRIBUTES}{}/{name}", &key[..7]), value);
            let conversion = "uint32_to_float32".to_owned();
            let all = [("name", layer), ("hash", "MurmurHash3_32".to_owned()), ("conversion", conversion)];
            all.into_iter().chain([("manifest", manifest)]).map(attribute).collect::<Vec<_>>()
        };
        self.mattes().iter().zip(names).flat_map(of_kind).collect()
    }
}

/// The id of a name. It is that of a finite normal float, so that no program changes its bits: one bit of a hash that has another exponent is
/// flipped (specification, "ID generation").
pub fn id_of(name: &str) -> u32 {
    let hash = hash_of(name);
    match hash >> 23 & 0xff {
        0 | 0xff => hash ^ 1 << 23,
        _ => hash,
    }
}

/// MurmurHash3_x86_32 with the seed 0 (A. Appleby, public domain).
fn hash_of(text: &str) -> u32 {
    let scrambled = |block: u32| block.wrapping_mul(0xcc9e_2d51).rotate_left(15).wrapping_mul(0x1b87_3593);
    let (blocks, tail) = text.as_bytes().as_chunks::<4>();
    let mixed = |hash: u32, block: &[u8; 4]| {
        (hash ^ scrambled(u32::from_le_bytes(*block))).rotate_left(13).wrapping_mul(5).wrapping_add(0xe654_6b64)
    };
    let tail = tail.iter().rev().fold(0, |word, byte| word << 8 | u32::from(*byte));
    let mut hash = blocks.iter().fold(0, mixed) ^ scrambled(tail) ^ text.len() as u32;
    for (shift, factor) in [(16, 0x85eb_ca6b), (13, 0xc2b2_ae35)] {
        hash = (hash ^ hash >> shift).wrapping_mul(factor);
    }
    hash ^ hash >> 16
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Vectors of other implementations, and what Blender 5.0 writes of its startup file.
    #[test]
    fn hashes_are_those_of_others() {
        for (text, hash) in [
            ("", 0),
            ("a", 0x3c25_69b2),
            ("ab", 0x9bbf_d75f),
            ("abc", 0xb3dd_93fa),
            ("aaaa", 0x7eee_d987),
            ("hello, world", 0x149b_bb7f),
            ("Küche 場景", 0x3f33_8d48),
            ("Cube", 0xa8fc_e865),
            ("ViewLayer.CryptoObject", 0x542c_afaf),
        ] {
            assert_eq!(hash_of(text), hash, "{text}");
        }
        assert_eq!(id_of("Material"), 0x3913_209d);
        // The exponent of an id is neither 0 nor 255.
        assert_eq!(id_of(""), 1 << 23);
        assert!((0..20_000).all(|number| f32::from_bits(id_of(&number.to_string())).is_normal()));
        assert!(!(0..20_000).all(|number| f32::from_bits(hash_of(&number.to_string())).is_normal()));
    }
}

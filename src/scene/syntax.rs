//! How scene files are parsed.

use std::collections::HashSet;
use std::fmt;

use ron::extensions::Extensions;
use serde::Deserializer;
use serde::de::{Error as _, MapAccess, Visitor};

use super::types::Material;

/// The limit on ron's recursion. An object takes four calls, so that objects can be nested about 60 deep.
/// A stack of 1 MiB is enough for that, even in a build without optimisation.
const RECURSION_LIMIT: usize = 256;

/// How scene files are parsed.
pub fn options() -> ron::Options {
    ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME).with_recursion_limit(RECURSION_LIMIT)
}

/// Reads a map as a list in the file's order. The second occurrence of a name is an error.
pub fn in_file_order<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<(String, Material)>, D::Error> {
    struct InFileOrder;

    impl<'de> Visitor<'de> for InFileOrder {
        type Value = Vec<(String, Material)>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a map of materials")
        }

        fn visit_map<M: MapAccess<'de>>(self, mut map: M) -> Result<Self::Value, M::Error> {
            let mut names = HashSet::new();
            let mut materials = Vec::new();
            while let Some(name) = map.next_key::<String>()? {
                if !names.insert(name.clone()) {
                    let message = format!("the material {name:?} is defined twice");
                    return Err(M::Error::custom(message));
                }
                materials.push((name, map.next_value()?));
            }
            Ok(materials)
        }
    }

    deserializer.deserialize_map(InFileOrder)
}

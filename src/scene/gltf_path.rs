//! How paths name glTF files, OBJ files and parts of them. A part stands behind a number sign: `room.glb#meshes/0/primitives/1`.

use std::borrow::Cow;
use std::fmt;
use std::path::{Path, PathBuf};

/// Whether the ending of a path says glTF.
pub fn is_gltf(path: &Path) -> bool {
    has_ending(path, &["gltf", "glb"])
}

/// Whether a path has one of these endings.
pub fn has_ending(path: &Path, endings: &[&str]) -> bool {
    path.extension().is_some_and(|ending| endings.iter().any(|known| ending.eq_ignore_ascii_case(known)))
}

/// A part of a glTF file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Part {
    /// A primitive of a mesh, in the mesh's own space.
    OfMesh {
        mesh: usize,
        primitive: usize,
    },
    /// A primitive of the mesh of a node in the scene: morphed, and moved by its joints, or by the node and those around it. At a time of the
    /// file's animations, or in its rest pose. With the number of an instance where the node has instances of its mesh.
    OfNode {
        node: usize,
        instance: Option<usize>,
        primitive: usize,
        seconds: Option<f64>,
    },
    /// A primitive of the mesh of a node in the mesh's own space: only morphed. At a time of the file's animations, or in its rest pose.
    Morphed {
        node: usize,
        primitive: usize,
        seconds: Option<f64>,
    },
    Image(usize),
    /// The faces of an OBJ file that have a material, counted in the order of their first faces.
    OfMaterial(usize),
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Part::OfMesh { mesh, primitive } => write!(f, "meshes/{mesh}/primitives/{primitive}"),
            Part::OfNode { node, instance, primitive, seconds } => {
                let instance = instance.map_or(String::new(), |instance| format!("/instances/{instance}"));
                write!(f, "nodes/{node}{instance}/primitives/{primitive}{}", at_time(*seconds))
            }
            Part::Morphed { node, primitive, seconds } => {
                write!(f, "nodes/{node}/mesh/primitives/{primitive}{}", at_time(*seconds))
            }
            Part::Image(image) => write!(f, "images/{image}"),
            Part::OfMaterial(material) => write!(f, "materials/{material}"),
        }
    }
}

/// The end of a part's path that says a time.
fn at_time(seconds: Option<f64>) -> String {
    seconds.map_or(String::new(), |seconds| format!("/seconds/{seconds}"))
}

impl Part {
    /// Its path in the JSON.
    pub fn to_json(self) -> String {
        match self {
            Part::OfMesh { mesh, primitive } => format!("meshes[{mesh}].primitives[{primitive}]"),
            Part::OfNode { node, .. } | Part::Morphed { node, .. } => format!("nodes[{node}]"),
            Part::Image(image) => format!("images[{image}]"),
            Part::OfMaterial(material) => format!("materials[{material}]"),
        }
    }
}

/// The file that a path names, and the part of it behind the number sign.
pub fn split(path: &Path) -> (Cow<'_, Path>, Option<Part>) {
    let whole_file = (Cow::Borrowed(path), None);
    let Some((file, part)) = path.to_str().and_then(|text| text.rsplit_once('#')) else { return whole_file };
    let words: Vec<&str> = part.split('/').collect();
    let (words, seconds) = match words.as_slice() {
        [words @ .., "seconds", seconds] => match seconds.parse::<f64>() {
            Ok(seconds) if !seconds.is_nan() => (words, Some(seconds)),
            _ => return whole_file,
        },
        words => (words, None),
    };
    let of_node = |node: &str, primitive: &str| Some((node.parse::<usize>().ok()?, primitive.parse::<usize>().ok()?));
    let part = match *words {
        ["nodes", node, "primitives", primitive] => {
            of_node(node, primitive).map(|(node, primitive)| Part::OfNode { node, instance: None, primitive, seconds })
        }
        ["nodes", node, "instances", instance, "primitives", primitive] => of_node(node, primitive)
            .zip(instance.parse().ok())
            .map(|((node, primitive), instance)| Part::OfNode { node, instance: Some(instance), primitive, seconds }),
        ["nodes", node, "mesh", "primitives", primitive] => {
            of_node(node, primitive).map(|(node, primitive)| Part::Morphed { node, primitive, seconds })
        }
        // The others are the same at all times.
        _ if seconds.is_some() => None,
        ["meshes", mesh, "primitives", primitive] => {
            mesh.parse().ok().zip(primitive.parse().ok()).map(|(mesh, primitive)| Part::OfMesh { mesh, primitive })
        }
        ["images", image] => image.parse().ok().map(Part::Image),
        ["materials", material] => material.parse().ok().map(Part::OfMaterial),
        _ => None,
    };
    let is_of = |part: &Part| match part {
        Part::OfMaterial(_) => has_ending(Path::new(file), &["obj"]),
        _ => is_gltf(Path::new(file)),
    };
    match part.filter(is_of) {
        Some(part) => (Cow::Owned(PathBuf::from(file)), Some(part)),
        None => whole_file,
    }
}

/// The path in a uri, with escapes such as %20 decoded.
pub fn unescape(uri: &str) -> String {
    let mut bytes = Vec::new();
    let mut rest = uri.as_bytes();
    while let Some((&first, after)) = rest.split_first() {
        let code = after.get(..2).and_then(|code| std::str::from_utf8(code).ok());
        let code = code.and_then(|code| u8::from_str_radix(code, 16).ok());
        (rest, _) = match (first, code) {
            (b'%', Some(byte)) => (after.get(2..).unwrap_or_default(), bytes.push(byte)),
            _ => (after, bytes.push(first)),
        };
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_may_name_a_part_of_a_gltf_file() {
        let times = [None, Some(0.0), Some(1.0 / 24.0), Some(-1e-9), Some(1e300)];
        let of_node = times.map(|seconds| Part::OfNode { node: 0, instance: None, primitive: 1, seconds });
        let of_instance = times.map(|seconds| Part::OfNode { node: 4, instance: Some(9), primitive: 0, seconds });
        let morphed = times.map(|seconds| Part::Morphed { node: 2, primitive: 0, seconds });
        assert_eq!(split(Path::new("a #1.obj#materials/2")), (Path::new("a #1.obj").into(), Some(Part::OfMaterial(2))));
        let others = [Part::OfMesh { mesh: 3, primitive: 12 }, Part::Image(7)];
        for part in others.into_iter().chain(of_node).chain(of_instance).chain(morphed) {
            let path = format!("a #1/room.GLB#{part}");
            assert_eq!(split(Path::new(&path)), (Path::new("a #1/room.GLB").into(), Some(part)));
        }
        for path in [
            "room.glb",
            "room.obj#images/1",
            "room.glb#materials/1",
            "room.glb#images/x",
            "a.glb#b.glb",
            "room.glb#images",
            "#images/0",
            "a.glb#images/0/seconds/1",
            "a.glb#nodes/0/primitives/0/seconds/NaN",
            "a.glb#nodes/0/primitives/0/seconds/",
            "a.glb#nodes/0/instances/x/primitives/0",
        ] {
            assert_eq!(split(Path::new(path)), (Path::new(path).into(), None));
        }
    }
}

//! A cube in a file of every format.

use base64::Engine;
use glam::{DVec3, Vec2};
use gpu_rt::scene::Mesh;

use super::gltf::glb;

/// A cube from -1 to 1 whose six quads have vertices of their own, with normals and texture coordinates.
#[derive(Clone, Default)]
pub struct Quads {
    pub positions: Vec<[f64; 3]>,
    pub normals: Vec<[f64; 3]>,
    pub uvs: Vec<[f64; 2]>,
    pub faces: Vec<Vec<usize>>,
}

const CORNERS: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

pub fn cube() -> Quads {
    let mut quads = Quads::default();
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let unit = |axis: usize| DVec3::from_array([0, 1, 2].map(|at| if at == axis % 3 { 1.0 } else { 0.0 }));
            let normal = unit(axis) * sign;
            let (u, v) = (unit(axis + 1) * sign, unit(axis + 2));
            assert_eq!(u.cross(v), normal);
            let first = quads.positions.len();
            for [s, t] in CORNERS {
                quads.positions.push((normal + u * (2.0 * s - 1.0) + v * (2.0 * t - 1.0)).to_array());
                quads.normals.push(normal.to_array());
                quads.uvs.push([s, t]);
            }
            quads.faces.push((first..first + 4).collect());
        }
    }
    quads
}

impl Quads {
    pub fn triangles(&self) -> Vec<[u32; 3]> {
        let fan = |face: &Vec<usize>| {
            let corner = |at: usize| face[at] as u32;
            (2..face.len()).map(|at| [corner(0), corner(at - 1), corner(at)]).collect::<Vec<_>>()
        };
        self.faces.iter().flat_map(fan).collect()
    }

    pub fn expected(&self) -> Mesh {
        let faces = self.faces.iter().enumerate();
        Mesh {
            positions: self.positions.iter().map(|&p| DVec3::from_array(p)).collect(),
            triangles: self.triangles(),
            normals: self.normals.iter().map(|&n| DVec3::from_array(n).as_vec3()).collect(),
            uvs: self.uvs.iter().map(|&[u, v]| Vec2::new(u as f32, v as f32)).collect(),
            faces: faces.flat_map(|(face, corners)| vec![face as u32; corners.len() - 2]).collect(),
            ..Mesh::default()
        }
    }

    pub fn obj(&self) -> String {
        let list = |name: &str, rows: Vec<Vec<f64>>| {
            rows.iter()
                .map(|row| format!("{name} {}\n", row.iter().map(f64::to_string).collect::<Vec<_>>().join(" ")))
                .collect::<String>()
        };
        let mut text = String::from("mtllib missing.mtl\no cube\n");
        text += &list("v", self.positions.iter().map(|p| p.to_vec()).collect());
        text += &list("vt", self.uvs.iter().map(|p| p.to_vec()).collect());
        text += &list("vn", self.normals.iter().map(|p| p.to_vec()).collect());
        text += "usemtl nothing\ng sides\ns off\n";
        for face in &self.faces {
            let corners = face.iter().map(|&corner| format!(" {0}/{0}/{0}", corner + 1)).collect::<String>();
            text += &format!("f{corners}\n");
        }
        text
    }

    /// As PLY: `kind` of the vertices' numbers, with other properties and elements in between.
    pub fn ply(&self, format: &str, kind: &str, uv_names: [&str; 2], list: &str) -> Vec<u8> {
        let mut bytes = format!(
            "ply\nformat {format} 1.0\ncomment a cube\nobj_info of nobody\nelement camera 2\nproperty uchar brand\n\
             property list uchar short shots\nelement vertex {}\nproperty {kind} nx\nproperty {kind} ny\n\
             property {kind} nz\nproperty uchar red\nproperty {kind} {}\nproperty {kind} {}\nproperty {kind} x\n\
             property list ushort float weights\nproperty {kind} y\nproperty {kind} z\nelement nothing 4000000000\n\
             element face {}\nproperty short flags\nproperty list uchar int {list}\n\
             property list uchar float texcoord\nend_header\n",
            self.positions.len(),
            uv_names[0],
            uv_names[1],
            self.faces.len()
        )
        .into_bytes();
        let real = if kind == "double" { 'd' } else { 'f' };
        let mut row = |values: &[(char, f64)]| {
            for &(kind, value) in values {
                let mut number = match kind {
                    _ if format == "ascii" => format!("{value} ").into_bytes(),
                    'b' => vec![value as u8],
                    's' => (value as i16).to_le_bytes().to_vec(),
                    'i' => (value as i32).to_le_bytes().to_vec(),
                    'f' => (value as f32).to_le_bytes().to_vec(),
                    _ => value.to_le_bytes().to_vec(),
                };
                if format == "binary_big_endian" {
                    number.reverse();
                }
                bytes.extend(number);
            }
            if format == "ascii" {
                bytes.push(b'\n');
            }
        };
        row(&[('b', 7.0), ('b', 2.0), ('s', -1.0), ('s', 1000.0)]);
        row(&[('b', 7.0), ('b', 0.0)]);
        for ((p, n), uv) in self.positions.iter().zip(&self.normals).zip(&self.uvs) {
            let normal = n.map(|c| (real, 2.0 * c));
            let rest = [('b', 255.0), (real, uv[0]), (real, uv[1]), (real, p[0])];
            let weights = [('s', 2.0), ('f', 0.5), ('f', 0.5), (real, p[1]), (real, p[2])];
            row(&[&normal[..], &rest, &weights].concat());
        }
        for face in &self.faces {
            let corners = face.iter().map(|&corner| ('i', corner as f64));
            let ends = [('s', -3.0), ('b', face.len() as f64)];
            row(&ends.into_iter().chain(corners).chain([('b', 1.0), ('f', 0.25)]).collect::<Vec<_>>());
        }
        bytes
    }

    /// The bytes of a glTF buffer: positions, normals, texture coordinates, indices of 16 bits.
    pub fn buffer(&self) -> Vec<u8> {
        let floats = |values: &[f64]| values.iter().flat_map(|&c| (c as f32).to_le_bytes()).collect::<Vec<_>>();
        let uvs: Vec<f64> = self.uvs.iter().flat_map(|&[u, v]| [u, 1.0 - v]).collect();
        let indices = self.triangles().into_iter().flatten().flat_map(|index| (index as u16).to_le_bytes());
        [floats(self.positions.as_flattened()), floats(self.normals.as_flattened()), floats(&uvs), indices.collect()]
            .concat()
    }

    /// As glTF's JSON, with this for the buffer's uri and for the node.
    pub fn gltf(&self, uri: &str, node: &str) -> String {
        let (count, triangles) = (self.positions.len(), self.triangles().len());
        let (normals, uvs, indices) = (12 * count, 24 * count, 32 * count);
        let end = indices + 6 * triangles;
        format!(
            r#"{{"asset": {{"version": "2.0"}}, "scene": 1,
  "scenes": [{{"nodes": []}}, {{"nodes": [1]}}],
  "nodes": [{{"mesh": 0 {node}}}, {{"children": [0], "translation": [0, 0, 0]}}],
  "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}}, "indices": 3}}]}}],
  "accessors": [
    {{"bufferView": 0, "componentType": 5126, "count": {count}, "type": "VEC3", "min": [-1, -1, -1], "max": [1, 1, 1]}},
    {{"bufferView": 1, "componentType": 5126, "count": {count}, "type": "VEC3"}},
    {{"bufferView": 2, "componentType": 5126, "count": {count}, "type": "VEC2"}},
    {{"bufferView": 3, "componentType": 5123, "count": {}, "type": "SCALAR"}}],
  "bufferViews": [
    {{"buffer": 0, "byteOffset": 0, "byteLength": {normals}}},
    {{"buffer": 0, "byteOffset": {normals}, "byteLength": {normals}}},
    {{"buffer": 0, "byteOffset": {uvs}, "byteLength": {}}},
    {{"buffer": 0, "byteOffset": {indices}, "byteLength": {}}}],
  "buffers": [{{{uri} "byteLength": {end}}}]}}"#,
            3 * triangles,
            indices - uvs,
            end - indices,
        )
    }

    pub fn gltf_with_base64(&self, node: &str) -> String {
        let data = base64::engine::general_purpose::STANDARD.encode(self.buffer());
        self.gltf(&format!(r#""uri": "data:application/octet-stream;base64,{data}","#), node)
    }

    pub fn glb(&self) -> Vec<u8> {
        glb(&serde_json::from_str(&self.gltf("", "")).expect("it is JSON"), &self.buffer())
    }
}

/// A file of every kind that holds the cube.
pub fn cubes() -> Vec<(&'static str, Vec<u8>)> {
    let cube = cube();
    vec![
        ("cube.obj", cube.obj().into_bytes()),
        ("ascii.ply", cube.ply("ascii", "float", ["u", "v"], "vertex_indices")),
        ("little.PLY", cube.ply("binary_little_endian", "float", ["s", "t"], "vertex_index")),
        ("big.ply", cube.ply("binary_big_endian", "double", ["texture_u", "texture_v"], "vertex_indices")),
        ("base64.gltf", cube.gltf_with_base64("").into_bytes()),
        ("binary.glb", cube.glb()),
    ]
}

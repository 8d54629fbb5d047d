//! The triangles of a glTF file.

use glam::{DAffine3, DVec3, Vec2, Vec3};
use gltf::accessor::Dimensions;
use gltf::json::Index;
use gltf::json::accessor::Accessor;
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;

use super::accessors::{ALL, Elements};
use super::deformation::{Deformation, NORMAL, POSITION, TANGENT};
use super::error::in_primitive;
use super::material::{UvTransform, is_opaque};
use super::nodes::SceneNode;
use super::{File, GltfError, Result};
use crate::scene::draft::{Draft, MOST_BYTES};
use crate::scene::gltf_path::Part;

/// Whether a primitive consists of triangles, and not of points or lines.
pub fn has_triangles(primitive: &Primitive) -> bool {
    matches!(primitive.mode, Checked::Valid(Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan))
}

/// A share in steps of 1/65535.
fn code(share: f64) -> u16 {
    (share.clamp(0.0, 1.0) * f64::from(u16::MAX)).round() as u16
}

/// The vertex colours of a primitive that has triangles.
fn colours_of(primitive: &Primitive) -> Option<Index<Accessor>> {
    let colours = primitive.attributes.get(&Checked::Valid(Semantic::Colors(0)));
    colours.copied().filter(|_| has_triangles(primitive))
}

impl File {
    /// Adds the meshes of the default scene, or of the first scene if there is no default, in the rest pose.
    pub fn add_scene(&self, draft: &mut Draft) -> Result<()> {
        let pose = self.pose(None)?;
        for scene_node in pose.nodes(self.root()) {
            let Some(mesh) = scene_node.node.mesh else { continue };
            let primitives = self.primitives(mesh.value(), scene_node.index)?;
            if !primitives.iter().any(has_triangles) {
                continue;
            }
            for to_scene in self.instances(&scene_node, 0)? {
                let placed = SceneNode { to_scene: to_scene?, ..scene_node };
                for (number, primitive) in primitives.iter().enumerate() {
                    let deformation = self.deformation(&pose, &placed, primitive)?;
                    self.add((mesh.value(), number), &deformation, &UvTransform::default(), draft)?;
                }
            }
        }
        Ok(())
    }

    /// Adds the triangles of a part, with the texture coordinates that its material uses.
    pub fn add_part(&self, part: Part, draft: &mut Draft) -> Result<()> {
        let (mesh, primitive, deformation) = match part {
            Part::OfMesh { mesh, primitive } => (mesh, primitive, Deformation::rigid(DAffine3::IDENTITY)),
            Part::OfNode { node, instance, primitive, seconds } => {
                self.of_node((node, instance), primitive, seconds)?
            }
            Part::Morphed { node, primitive, seconds } => {
                let (mesh, primitive, deformation) = self.of_node((node, None), primitive, seconds)?;
                (mesh, primitive, deformation.in_mesh())
            }
            Part::Image(_) | Part::OfMaterial(_) => {
                return Err("expected a mesh, such as #meshes/0/primitives/0".to_owned().into());
            }
        };
        let placings = self.uv_placings(mesh, primitive)?;
        self.add((mesh, primitive), &deformation, placings.first().unwrap_or(&UvTransform::default()), draft)?;
        let count = draft.positions.len();
        // An image on a primitive without texture coordinates has one colour, as where these are 0 in other programs.
        let constant = |placing: &UvTransform| std::iter::repeat_n(placing.in_mesh([0.0; 2]), count);
        if let Some(first) = placings.first().filter(|_| draft.uvs.is_empty()) {
            draft.uvs = constant(first).collect();
        }
        for placing in placings.iter().skip(1) {
            match self.uvs(mesh, primitive, placing)? {
                Some(uvs) => draft.add_uvs(uvs)?,
                None => draft.add_uvs(constant(placing))?,
            }
        }
        if self.has_normal_map(mesh, primitive)? && !draft.normals.is_empty() {
            self.add_tangents((mesh, primitive), &deformation, draft)?;
        }
        Ok(())
    }

    /// The mesh of a node, or of one of its instances, and what happens to a primitive of it at a time.
    fn of_node(
        &self,
        (node, instance): (usize, Option<usize>),
        primitive: usize,
        seconds: Option<f64>,
    ) -> Result<(usize, usize, Deformation)> {
        let wrong = |reason: &str| GltfError::new(format!("nodes[{node}]"), reason);
        let pose = self.pose(seconds)?;
        let scene_node = pose.node(self.root(), node).ok_or_else(|| wrong("expected a node of the default scene"))?;
        let mesh = scene_node.node.mesh.ok_or_else(|| wrong("expected a node with a mesh"))?.value();
        let placed = SceneNode { to_scene: self.instance(&scene_node, instance)?, ..scene_node };
        let deformation = self.deformation(&pose, &placed, self.primitive(mesh, primitive)?)?;
        Ok((mesh, primitive, deformation))
    }

    /// Whether all primitives of a mesh together are closed around a volume. Exporters split vertices at seams, creases and materials, so
    /// those at one position count as one.
    pub fn is_closed(&self, mesh: usize) -> bool {
        let mut draft = Draft::new(MOST_BYTES);
        let count = self.root().meshes.get(mesh).map_or(0, |mesh| mesh.primitives.len());
        let as_stored = Deformation::rigid(DAffine3::IDENTITY);
        // What is broken is reported where the mesh is read.
        let read = (0..count).try_for_each(|primitive| self.add_faces((mesh, primitive), &as_stored, &mut draft));
        let mesh = read.ok().and_then(|()| draft.finish().ok());
        mesh.is_some_and(|mesh| mesh.open_edges().is_none() && mesh.has_volume())
    }

    /// The accessor of an attribute that every vertex of a primitive has. Others are not used.
    fn complete_attribute(&self, primitive: &Primitive, semantic: Semantic) -> Option<Index<Accessor>> {
        let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
        let count = |index| self.accessor(index).map(|accessor| accessor.count.0);
        let vertices = self.vertex_count(primitive);
        attribute(semantic).filter(|&index| count(index).is_none_or(|found| found == vertices))
    }

    /// The texture coordinates of a primitive, transformed. `None` if it does not have this set.
    fn uvs(&self, mesh: usize, primitive: usize, placing: &UvTransform) -> Result<Option<impl Iterator<Item = Vec2>>> {
        let set = placing.set;
        let Some(index) = self.complete_attribute(self.primitive(mesh, primitive)?, Semantic::TexCoords(set)) else {
            return Ok(None);
        };
        let wrong = |reason| in_primitive((mesh, primitive), &format!(".attributes.TEXCOORD_{set}"), reason);
        let uvs = self.elements::<2>(index, ALL).map_err(wrong)?;
        Ok(Some(uvs.map(|uv| placing.in_mesh(uv))))
    }

    /// Adds the tangents of a primitive's vertices, if it has them.
    fn add_tangents(
        &self,
        (mesh, primitive): (usize, usize),
        deformation: &Deformation,
        draft: &mut Draft,
    ) -> Result<()> {
        let given = self.primitive(mesh, primitive)?;
        let Some(&index) = given.attributes.get(&Checked::Valid(Semantic::Tangents)) else { return Ok(()) };
        let wrong = |reason: String| in_primitive((mesh, primitive), ".attributes.TANGENT", reason);
        let (found, expected) = (self.accessor(index).map_or(0, |accessor| accessor.count.0), draft.positions.len());
        if found != expected as u64 {
            return Err(wrong(format!("expected a tangent for each of {expected} vertices, found {found}")));
        }
        let tangents = self.elements::<4>(index, ALL).map_err(wrong)?;
        let mut morphed = self.morph((mesh, primitive), deformation, TANGENT)?;
        let transforms = self.transforms((mesh, primitive), deformation)?;
        let transformed = tangents.zip(transforms).map(|([x, y, z, w], to_scene)| {
            let along = (to_scene.matrix3 * morphed(DVec3::new(x, y, z))).normalize();
            let sign = to_scene.matrix3.determinant().signum();
            along.as_vec3().extend((sign * w) as f32)
        });
        Ok(draft.add_tangents(transformed)?)
    }

    /// The primitives of a node's mesh.
    pub fn primitives(&self, mesh: usize, node: usize) -> Result<&[Primitive]> {
        let found = self.root().meshes.get(mesh).map(|mesh| mesh.primitives.as_slice());
        found.ok_or_else(|| GltfError::new(format!("nodes[{node}].mesh"), format!("there is no mesh {mesh}")))
    }

    /// A primitive of a mesh.
    pub fn primitive(&self, mesh: usize, primitive: usize) -> Result<&Primitive> {
        let wrong = |at: String, what: &str, number: usize| GltfError::new(at, format!("there is no {what} {number}"));
        let found = self.root().meshes.get(mesh).ok_or_else(|| wrong("meshes".to_owned(), "mesh", mesh))?;
        let primitives = format!("meshes[{mesh}].primitives");
        found.primitives.get(primitive).ok_or_else(|| wrong(primitives, "primitive", primitive))
    }

    /// Whether a primitive has vertex colours other than white, which exporters write too.
    pub fn is_coloured(&self, primitive: &Primitive) -> bool {
        let is_coloured =
            |colours| self.colours(colours).is_ok_and(|mut all| !all.all(|colour| colour == [u16::MAX; 3]));
        colours_of(primitive).is_some_and(is_coloured)
    }

    /// Whether a primitive has vertices whose alpha is less than 1.
    pub fn has_vertex_alpha(&self, primitive: &Primitive) -> bool {
        let is_there = |mut all: Elements<'_, u16>| all.any(|alpha| alpha != u16::MAX);
        colours_of(primitive).is_some_and(|colours| self.alphas(colours).is_ok_and(is_there))
    }

    /// Vertex colours with their alpha, which is 1 if they have three numbers.
    fn rgba(&self, index: Index<Accessor>) -> std::result::Result<Elements<'_, [f64; 4]>, String> {
        match self.accessor(index).map(|accessor| accessor.type_) {
            Some(Checked::Valid(Dimensions::Vec3)) => {
                Ok(Box::new(self.elements::<3>(index, ALL)?.map(|[r, g, b]| [r, g, b, 1.0])))
            }
            _ => self.elements::<4>(index, ALL),
        }
    }

    fn alphas(&self, index: Index<Accessor>) -> std::result::Result<Elements<'_, u16>, String> {
        Ok(Box::new(self.rgba(index)?.map(|[.., alpha]| code(alpha))))
    }

    /// Vertex colours, linear, without their alpha.
    fn colours(&self, index: Index<Accessor>) -> std::result::Result<Elements<'_, [u16; 3]>, String> {
        if let Some(vertex) = self.rgba(index)?.position(|colour| !colour.iter().all(|x| x.is_finite())) {
            return Err(format!("expected finite numbers, found others at vertex {vertex}"));
        }
        Ok(Box::new(self.rgba(index)?.map(|[r, g, b, _]| [r, g, b].map(code))))
    }

    /// Adds a primitive's triangles with what its vertices have; points and lines have none.
    fn add(
        &self,
        (mesh, number): (usize, usize),
        deformation: &Deformation,
        placing: &UvTransform,
        draft: &mut Draft,
    ) -> Result<()> {
        let wrong = |part: &str, reason: String| in_primitive((mesh, number), part, reason);
        let primitive = self.primitive(mesh, number)?;
        if !has_triangles(primitive) {
            return Ok(());
        }
        let first = draft.positions.len();
        self.add_faces((mesh, number), deformation, draft)?;
        let attribute = |semantic| self.complete_attribute(primitive, semantic);
        let normals = attribute(Semantic::Normals).map(|index| self.elements::<3>(index, ALL)).transpose();
        let normals = normals.map_err(|reason| wrong(".attributes.NORMAL", reason))?;
        let uvs = self.uvs(mesh, number, placing)?;
        let colours = attribute(Semantic::Colors(0)).map(|index| self.colours(index)).transpose();
        let colours = colours.map_err(|reason| wrong(".attributes.COLOR_0", reason))?;
        // Opaque materials ignore it.
        let has_alpha = self.material_of(mesh, number)?.is_some_and(|material| !is_opaque(material));
        let alphas = attribute(Semantic::Colors(0)).filter(|_| has_alpha).map(|index| self.alphas(index)).transpose();
        let alphas = alphas.map_err(|reason| wrong(".attributes.COLOR_0", reason))?;

        if let Some(colours) = colours {
            draft.colour(first, colours)?;
        }
        if let Some(alphas) = alphas {
            draft.add_alphas(first, alphas)?;
        }
        if let Some(normals) = normals {
            draft.normals.resize(first, Vec3::NAN);
            let mut morphed = self.morph((mesh, number), deformation, NORMAL)?;
            let transforms = self.transforms((mesh, number), deformation)?;
            for (vertex, (normal, to_scene)) in normals.map(DVec3::from_array).zip(transforms).enumerate() {
                if !normal.is_finite() {
                    draft.bad_normal.get_or_insert_with(|| {
                        let reason = format!("expected finite numbers, found {normal} at vertex {vertex}");
                        wrong(".attributes.NORMAL", reason).to_string()
                    });
                }
                draft.normals.push(deformation.normal(&to_scene, morphed(normal)).as_vec3());
            }
        }
        if let Some(uvs) = uvs {
            draft.uvs.resize(first, Vec2::NAN);
            draft.uvs.extend(uvs);
            let bad = draft.uvs.iter().skip(first).enumerate().find(|(_, uv)| !uv.is_finite());
            if let Some((vertex, uv)) = bad.filter(|_| draft.bad_uv.is_none()) {
                let reason = format!("expected finite numbers, found {uv} at vertex {vertex}");
                draft.bad_uv = Some(wrong(&format!(".attributes.TEXCOORD_{}", placing.set), reason).to_string());
            }
        }
        Ok(())
    }

    /// Adds a primitive's triangles with the positions of its vertices; points and lines have none.
    fn add_faces(&self, (mesh, number): (usize, usize), deformation: &Deformation, draft: &mut Draft) -> Result<()> {
        let wrong = |part: &str, reason: String| in_primitive((mesh, number), part, reason);
        let primitive = self.primitive(mesh, number)?;
        let Checked::Valid(mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) = primitive.mode else {
            return Ok(());
        };
        let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
        let positions = attribute(Semantic::Positions)
            .ok_or_else(|| wrong(".attributes", "expected an attribute POSITION".to_owned()))?;
        let count = self.accessor(positions).map_or(0, |accessor| accessor.count.0);
        let positions = self.elements::<3>(positions, ALL).map_err(|reason| wrong(".attributes.POSITION", reason))?;
        let first = draft.positions.len();
        let mut morphed = self.morph((mesh, number), deformation, POSITION)?;
        let mut mirrored = 0;
        for (position, to_scene) in positions.zip(self.transforms((mesh, number), deformation)?) {
            draft.vertex(to_scene.transform_point3(morphed(DVec3::from_array(position))))?;
            mirrored += u64::from(to_scene.matrix3.determinant() < 0.0);
        }
        // Of a skin, most of the vertices decide.
        let is_mirrored = deformation.mirrors().unwrap_or(mirrored > count / 2);
        let corners = match primitive.indices {
            Some(indices) => self.indices(indices).map_err(|reason| wrong(".indices", reason))?,
            None => Box::new(0..count),
        };
        // The corners before this one that its triangle has too.
        let mut held = [0; 2];
        for (at, index) in corners.enumerate() {
            if index >= count {
                let face = draft.face_count;
                return Err(wrong(
                    ".indices",
                    format!(
                        "face {face} (counted from 0) or a later one: there is no vertex {index}; the primitive has {count}, \
                         counted from 0"
                    ),
                ));
            }
            let c = first as u32 + index as u32;
            let [a, b] = held;
            let (corners, next) = match mode {
                Mode::TriangleStrip => (if at % 2 == 0 { [a, b, c] } else { [b, a, c] }, [b, c]),
                Mode::TriangleFan => ([a, b, c], if at == 0 { [c, c] } else { [a, c] }),
                _ => ([a, b, c], if at % 3 == 0 { [c, c] } else { [a, c] }),
            };
            let is_last = if mode == Mode::Triangles { at % 3 == 2 } else { at >= 2 };
            if is_last {
                let [a, b, c] = corners;
                draft.face(&if is_mirrored { [a, c, b] } else { [a, b, c] })?;
            }
            held = next;
        }
        Ok(())
    }
}

//! The contents of a glTF file as objects and materials.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::Arc;

use glam::DAffine3;
use gltf::json::mesh::Primitive;
use gltf::json::scene::Node;

use super::camera::View;
use super::deformation::has_more_joints;
use super::error::in_primitive;
use super::generator::LightUnits;
use super::geometry::has_triangles;
use super::instances::{self, MOST_INSTANCES, has_instances, has_unread_instances};
use super::material::{Glass, OfVertices, default_material, is_glass, is_opaque, thickness};
use super::nodes::{SceneNode, similarity};
use super::{File, GltfError, Result, is_read};
use crate::guard::guarded;
use crate::printable::{one_line, quote};
use crate::scene::gltf_path::Part;
use crate::scene::nearest::{meant, one_of};
use crate::scene::types::{Camera, ImageSize, Material, Object, Thin};
use crate::shape::Aabb;
use crate::shape::mesh::Mesh;

/// The words by which users have a file read in another way.
#[derive(Debug, PartialEq, Eq)]
pub struct Asker {
    /// Lights are not in watts.
    watts_off: &'static str,
    /// Glass without a thickness is thin.
    thin_pane: &'static str,
    /// The time of its animations.
    frame: &'static str,
}

/// By the options of the command line.
pub const OPTIONS: Asker = Asker { watts_off: "--watts=off", thin_pane: "--thin pane", frame: "--frame N" };
/// By the fields of a Gltf object in a scene file.
pub const OBJECT: Asker = Asker { watts_off: "watts: false", thin_pane: "thin: Pane", frame: "frame: N" };

/// The choices of reading a file where glTF and Blender differ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    pub asker: &'static Asker,
    /// Whether its lights are in Blender's watts; if it is not given, the file's generator decides.
    pub watts: Option<bool>,
    pub thin: Thin,
    /// The time of its animations; its rest pose if it is not given.
    pub seconds: Option<f64>,
}

/// The contents of the default scene of a file.
#[derive(Default)]
pub struct Contents {
    pub materials: Vec<(String, Material)>,
    pub objects: Vec<Object>,
    /// The name of the topmost node above each object.
    pub assets: Vec<String>,
    /// The meshes of the objects with their transforms, for a camera that sees them all.
    pub meshes: Vec<(String, DAffine3)>,
    /// In the order of their nodes.
    pub views: Vec<View>,
    /// Notes about what is not as the file says, each with its path in the JSON.
    pub notes: Vec<String>,
}

impl Contents {
    /// The camera of this name, or the first one; nothing where there is none.
    pub fn choose(&mut self, name: Option<&str>) -> std::result::Result<Option<(Camera, ImageSize)>, String> {
        let chosen = match name {
            None => self.views.first(),
            Some(name) => {
                const MOST: usize = 10;
                let is_it = |view: &&View| view.names.iter().any(|known| known == name);
                let mut known: Vec<&str> = self.views.iter().flat_map(|view| &view.names).map(String::as_str).collect();
                known.dedup();
                let known = || known.iter().copied();
                self.views.iter().find(is_it).map(Some).ok_or_else(|| {
                    let names = one_of(known().take(MOST), "the file has no perspective camera with a name");
                    format!("--camera: there is no camera {name:?}: {names}{}", meant(name, known()))
                })?
            }
        };
        Ok(chosen.map(|view| (view.camera.clone(), view.image)))
    }

    /// Whether it has lights without size.
    pub fn has_lights(&self) -> bool {
        self.objects.iter().any(|object| object.unnamed().delta_light().is_some())
    }
}

/// The smallest box around transformed meshes.
pub fn bounds(objects: &[(String, DAffine3)], meshes: &BTreeMap<String, Arc<Mesh>>) -> Aabb {
    let known = objects.iter().filter_map(|(path, to_scene)| Some((meshes.get(path)?, to_scene)));
    Aabb::around(known.flat_map(|(mesh, to_scene)| mesh.bounds().corners().map(|p| to_scene.transform_point3(p))))
}

impl File {
    /// The contents of the default scene. `path` is the file as the scene names it; names of materials begin with `prefix`.
    pub fn contents(&self, path: &str, prefix: &str, reading: &Reading) -> Result<Contents> {
        guarded(|| self.read_contents(path, prefix, reading))?
    }

    /// The units of its lights, and a note if its generator alone says so.
    fn light_units(&self, reading: &Reading) -> (LightUnits, Option<String>) {
        let Some(blender) = self.blender() else {
            let units =
                if reading.watts == Some(true) { LightUnits::WattsTimesLumens } else { LightUnits::Photometric };
            return (units, None);
        };
        let (units, off) = (blender.light_units(), reading.asker.watts_off);
        let note = match (reading.watts, units) {
            (Some(false), _) => return (LightUnits::Photometric, None),
            (Some(true), _) | (None, LightUnits::Photometric) => None,
            (None, LightUnits::WattsTimesLumens) => Some(format!(
                "asset.generator: Blender writes the watts of its lights times 683 lm/W, so they are divided by that: {off} for a file \
                 exported with Lighting Mode \"Unitless\""
            )),
            (None, LightUnits::Watts) => Some(format!(
                "asset.generator: Blender's exporter before 3.4 wrote the watts of its lights, so those of points and spots are divided \
                 by 4 pi: {off} reads them as candela"
            )),
        };
        (units, note)
    }

    fn read_contents(&self, path: &str, prefix: &str, reading: &Reading) -> Result<Contents> {
        let root = self.root();
        let mut contents = Contents::default();
        let mut materials = Materials {
            file: self,
            path,
            prefix,
            reading,
            names: HashMap::new(),
            taken: HashSet::new(),
            closed: HashMap::new(),
            reported: HashSet::new(),
            primitives: HashMap::new(),
        };
        for primitive in root.meshes.iter().flat_map(|mesh| &mesh.primitives) {
            materials.primitives.entry(primitive.material.map(|it| it.value())).or_default().push(primitive);
        }
        let mut deviations = Deviations::default();
        let (units, note_of_units) = self.light_units(reading);
        let mut of_mesh = HashSet::new();
        let pose = self.pose(reading.seconds)?;
        contents.notes.extend(pose.notes.iter().cloned());
        for scene_node in pose.nodes(root) {
            contents.views.extend(self.view(&scene_node)?);
            if let Some(light) = self.light(&scene_node, units)? {
                contents.objects.push(named(&scene_node, light.object));
                contents.assets.push(asset_of(&root.nodes, &scene_node));
                deviations.has_range |= light.has_range;
            }
            let Some(mesh) = scene_node.node.mesh.map(|mesh| mesh.value()) else { continue };
            let is_skinned = scene_node.node.skin.is_some();
            // What stands still has one name at all times, so that it stays in memory from frame to frame.
            let is_moved =
                scene_node.is_moved || pose.seconds.is_some() && self.has_moved_joints(&pose, &scene_node)?;
            let is_animated = pose.weights(scene_node.index).is_some();
            let (node, at) = (scene_node.index, |changes: bool| pose.seconds.filter(|_| changes));
            let is_first = of_mesh.insert(mesh);
            let has_instances = has_instances(scene_node.node);
            deviations.unread_instances =
                deviations.unread_instances.or(has_unread_instances(scene_node.node).then_some(node));
            // By primitive: whether it is morphed, and its material. None for points and lines.
            let mut primitives = Vec::new();
            for (index, primitive) in self.primitives(mesh, node)?.iter().enumerate() {
                if !has_triangles(primitive) {
                    deviations.without_triangles += 1;
                    continue;
                }
                let is_morphed = self.is_morphed(&pose, &scene_node, primitive);
                let material = primitive.material.map(|material| material.value());
                primitives.push((index, is_morphed, materials.name(material, (mesh, index), &mut contents)?));
            }
            if primitives.is_empty() {
                continue;
            }
            for (number, to_scene) in self.instances(&scene_node, 0)?.enumerate() {
                let (to_scene, instance) = (to_scene?, has_instances.then_some(number));
                deviations.of_instances += if has_instances { primitives.len() as u64 } else { 0 };
                if deviations.of_instances > MOST_INSTANCES {
                    let reason = format!("expected at most {MOST_INSTANCES} instances of primitives, found more");
                    return Err(GltfError::new(format!("nodes[{node}].extensions.{}", instances::EXTENSION), reason));
                }
                // A skin moves vertices one by one, whatever the transform of the node is.
                let transforms = similarity(&to_scene).filter(|_| !is_skinned);
                if transforms.is_none() && !is_skinned && !(is_first && number == 0) {
                    deviations.baked.push(node);
                }
                for &(primitive, is_morphed, ref material) in &primitives {
                    let part = match transforms {
                        Some(_) if is_morphed => Part::Morphed { node, primitive, seconds: at(is_animated) },
                        Some(_) => Part::OfMesh { mesh, primitive },
                        None => Part::OfNode { node, instance, primitive, seconds: at(is_moved || is_animated) },
                    };
                    let part = format!("{path}#{part}");
                    let object = Object::Mesh { path: part.clone(), material: Some(material.clone()) };
                    let object = match &transforms {
                        Some(by) if !by.is_empty() => Object::Transformed { by: by.clone(), object: Box::new(object) },
                        _ => object,
                    };
                    contents.objects.push(named(&scene_node, object));
                    contents.assets.push(asset_of(&root.nodes, &scene_node));
                    let to_scene = if transforms.is_some() { to_scene } else { DAffine3::IDENTITY };
                    contents.meshes.push((part, to_scene));
                }
            }
        }
        let has_lights = contents.has_lights();
        let notes = &mut contents.notes;
        notes.extend(note_of_units.filter(|_| has_lights));
        notes.extend(deviations.notes(root, reading));
        Ok(contents)
    }
}

/// The name of the topmost node above this one, or its place in the file.
fn asset_of(nodes: &[Node], node: &SceneNode) -> String {
    let name = nodes.get(node.topmost).and_then(|node| node.name.as_deref()).filter(|name| !name.is_empty());
    name.map_or_else(|| format!("nodes[{}]", node.topmost), |name| one_line(name).into_owned())
}

/// The object with the name of its node, if that has one.
fn named(node: &SceneNode, object: Object) -> Object {
    match node.node.name.as_deref().filter(|name| !name.is_empty()) {
        Some(name) => Object::Named { name: one_line(name).into_owned(), object: Box::new(object) },
        None => object,
    }
}

/// The properties of a file that objects and materials lack, or have in another way.
#[derive(Default)]
struct Deviations {
    /// The primitives of points and lines.
    without_triangles: usize,
    /// Whether a light has a range.
    has_range: bool,
    /// The instances of primitives.
    of_instances: u64,
    /// The first node whose instances are not read.
    unread_instances: Option<usize>,
    /// The nodes whose transforms are applied to vertices.
    baked: Vec<usize>,
}

impl Deviations {
    fn notes(&self, root: &gltf::json::Root, reading: &Reading) -> Vec<String> {
        let mut notes = Vec::new();
        let unread: Vec<String> = root.extensions_used.iter().filter(|name| !is_read(name)).map(quote).collect();
        if !unread.is_empty() {
            notes.push(format!("extensionsUsed: not read: {}", unread.join(", ")));
        }
        if let Some(first) = self.baked.first() {
            let count = self.baked.len();
            let them = match (self.of_instances > 0, count == 1) {
                (false, true) => "node",
                (false, false) => "nodes",
                (true, true) => "node or instance",
                (true, false) => "nodes or instances",
            };
            notes.push(format!(
                "nodes[{first}]: transforms that mirror or scale unevenly are applied to the vertices: {count} {them} cannot share a mesh \
                 with others, which takes memory"
            ));
        }
        if !root.animations.is_empty() && reading.seconds.is_none() {
            notes.push(format!("animations are not read without a frame: {} poses them", reading.asker.frame));
        }
        if let Some(node) = self.unread_instances {
            notes.push(format!("nodes[{node}]: {} is not read beside a skin", instances::EXTENSION));
        }
        let without_triangles = self.without_triangles;
        if without_triangles > 0 {
            notes.push(format!("meshes: {without_triangles} primitives of points or lines are left out"));
        }
        if root.meshes.iter().flat_map(|mesh| &mesh.primitives).any(has_more_joints) {
            notes.push("meshes: JOINTS_2 and later are not read: only 8 joints of a vertex count".to_owned());
        }
        if self.has_range {
            let note = "extensions.KHR_lights_punctual: the range of lights is not read: their light has no limit";
            notes.push(note.to_owned());
        }
        notes
    }
}

/// The materials that objects have named.
struct Materials<'a> {
    file: &'a File,
    path: &'a str,
    prefix: &'a str,
    reading: &'a Reading,
    /// By their numbers, and by whether they are solids.
    names: HashMap<(Option<usize>, bool), String>,
    taken: HashSet<String>,
    /// Whether meshes are closed, as far as that was needed.
    closed: HashMap<usize, bool>,
    /// The notes on them.
    reported: HashSet<String>,
    /// The primitives of each of the file's materials, by its number.
    primitives: HashMap<Option<usize>, Vec<&'a Primitive>>,
}

impl Materials<'_> {
    /// The form of a material's glass on a mesh. Blender renders closed meshes as solids and knows no thickness, unless a group of nodes
    /// has it for the exporter; and it takes the root of the base colour at each surface.
    fn glass(&mut self, index: Option<usize>, mesh: usize) -> Glass {
        let given = index.and_then(|index| self.file.root().materials.get(index));
        let Some(given) = given.filter(|given| is_glass(given)) else { return Glass::default() };
        let thickness = thickness(given);
        let is_thick = thickness.is_some_and(|thickness| thickness > 0.0);
        if self.reading.thin == Thin::Pane || self.file.blender().is_none() {
            return Glass { is_solid: is_thick, ..Glass::default() };
        }
        let by_shape = thickness.is_none();
        let file = self.file;
        let mut is_closed = || *self.closed.entry(mesh).or_insert_with(|| file.is_closed(mesh));
        let is_solid = if by_shape { is_closed() } else { is_thick };
        Glass { is_solid, by_shape, colour_of_body: is_solid }
    }

    /// Says what glass became by the shape of its meshes, and how it becomes the other.
    fn note_of_glass(&self, index: usize, glass: Glass) -> Option<String> {
        let given = self.file.root().materials.get(index).filter(|_| glass.by_shape)?;
        let name = given.name.as_ref().map_or(String::new(), |name| format!(" ({})", quote(name)));
        let became = match glass.is_solid {
            true => format!(
                "read as solid glass, because its mesh is closed, as Blender renders it: {} reads the thin pane that the file describes",
                self.reading.asker.thin_pane
            ),
            false => "read as a thin pane, because its mesh has holes or faces of both windings: for solid glass close the mesh, or give a \
                      Thickness in the node group glTF Material Output"
                .to_owned(),
        };
        Some(format!("materials[{index}]{name}: {became}"))
    }

    /// The name of a material, which is added if it is new. Nothing stands for the default.
    fn name(
        &mut self,
        index: Option<usize>,
        (mesh, primitive): (usize, usize),
        contents: &mut Contents,
    ) -> Result<String> {
        let glass = self.glass(index, mesh);
        if let Some(name) = self.names.get(&(index, glass.is_solid)) {
            return Ok(name.clone());
        }
        let of_this = self.primitives.get(&index).map_or(&[][..], Vec::as_slice);
        let given = index.and_then(|index| self.file.root().materials.get(index));
        let is_opaque = given.is_none_or(is_opaque);
        let of_vertices = OfVertices {
            colors: of_this.iter().any(|primitive| self.file.is_coloured(primitive)),
            alpha: !is_opaque && of_this.iter().any(|primitive| self.file.has_vertex_alpha(primitive)),
        };
        let (own, material) = match (index, given) {
            (Some(index), None) => {
                return Err(in_primitive((mesh, primitive), ".material", format!("there is no material {index}")));
            }
            (Some(index), Some(given)) => {
                let mut notes = Vec::new();
                let material = self.file.material((index, given), self.path, of_vertices, glass, &mut notes)?;
                notes.extend(self.note_of_glass(index, glass));
                notes.retain(|note| self.reported.insert(note.clone()));
                contents.notes.extend(notes);
                let own = given.name.clone().filter(|name| !name.is_empty()).unwrap_or(format!("material {index}"));
                let has_other = self.names.contains_key(&(Some(index), !glass.is_solid));
                let body = if glass.is_solid { "solid" } else { "pane" };
                (if has_other { format!("{own} ({body})") } else { own }, material)
            }
            (None, _) => {
                let of_blender = self.file.blender().is_some();
                let note = "meshes: those without a material are grey plastic, as Blender renders them";
                contents.notes.extend(of_blender.then(|| note.to_owned()));
                ("default".to_owned(), Material::Pbr(default_material(of_blender, of_vertices.colors)))
            }
        };
        let mut name = format!("{}{own}", self.prefix);
        while !self.taken.insert(name.clone()) {
            name += &index.map_or(" (default)".to_owned(), |index| format!(" ({index})"));
        }
        self.names.insert((index, glass.is_solid), name.clone());
        contents.materials.push((name.clone(), material));
        Ok(name)
    }
}

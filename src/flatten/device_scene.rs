//! A scene in the layout of the kernels.

use std::collections::HashMap;
use std::sync::Arc;

use super::features::Features;
use super::neighbours::Neighbours;
use super::view::Placement;
use crate::aov::{Aovs, SceneSpace};
use crate::bitmap::SRGB;
use crate::bvh::Bvh;
use crate::data::{self, HIT_NOTHING, KIND_TRIANGLE, PRIMITIVE_BIT, Tables, primitive_code};
use crate::lobe::Rows;
use crate::options::{LightPaths, RenderOptions};
use crate::scene::{Bitmap, Scene};

/// Light paths pay if the solid angle of the lights, seen from what is specular, is below this, in sr. Measured (docs/dev/performance-log.md).
const LARGEST_SOLID_ANGLE: f64 = 0.17;
/// The best number of light paths for eight samples where a light has no size. Measured (docs/dev/performance-log.md).
const PATHS_TO_DELTA_LIGHTS: u32 = 4;

/// Stands for the group of a light that has none.
pub const NO_GROUP: u32 = u32::MAX;

/// A scene in the layout of the kernels.
#[derive(Clone, Debug, Default)]
pub struct DeviceScene {
    pub features: Features,
    /// The camera, the background and the BVH's root. The render fills in the other settings.
    pub settings: data::Settings,
    pub placement: Placement,
    pub nodes: Vec<data::Node>,
    pub shapes: Tables,
    /// Faces, vertices and texture coordinates of all meshes, in the layout of shaders/bind/meshes.
    pub meshes: Vec<[u32; 4]>,
    /// The leaves of the meshes' hierarchies.
    pub face_pairs: Vec<data::FacePair>,
    pub media: Vec<data::Medium>,
    /// How the density of each medium varies, then the temperatures of some; empty if none does.
    pub fields: Vec<data::ScalarField>,
    /// The words of the grids of media, in the layout of shaders/medium/grid.
    pub bricks: Vec<u32>,
    pub lights: Vec<data::Light>,
    pub delta_lights: Vec<data::DeltaLight>,
    /// The tree over the lights; empty if there are fewer than two.
    pub light_nodes: Vec<data::LightNode>,
    /// The distribution of directions by the background's image.
    pub sky: Vec<u32>,
    /// For each light, its probability as the start of a light path; empty if the scene has none.
    pub emitters: Vec<data::AliasEntry>,
    /// Boxes at which light paths are aimed. Only the numbers of their shape count.
    pub aims: Vec<data::Cuboid>,
    pub materials: Vec<data::Material>,
    /// The extensions of each row of `materials`; empty if no material has one.
    pub extensions: Vec<Rows>,
    /// The table of directional albedos; empty if no material has energy compensation.
    pub directional_albedos: Vec<[f32; 4]>,
    /// The names in the scene file of the rows of `materials`.
    pub material_names: Vec<String>,
    /// With `--aov object`: the names of the primitives, in the order of their numbers.
    pub object_names: Vec<String>,
    /// With `--aov lights`: the groups of lights, in order.
    pub light_groups: Vec<String>,
    /// The number of the group of each light without size, then of each row of `materials`; [`NO_GROUP`] where there is none.
    pub groups_of_lights: Vec<u32>,
    /// With mattes: the ids of each object in the order of their numbers, one of each kind; and the names of each kind.
    pub matte_ids: Vec<u32>,
    pub matte_names: Vec<Vec<String>>,
    /// How objects move while the shutter is open (shaders/data/motion); empty if nothing does.
    pub motions: Vec<[u32; 4]>,
    pub textures: Vec<data::Texture>,
    pub frames: Vec<data::Frame>,
    /// The images, in the order of their texels, each with its path. The texels are the scene's own: a copy may take 2 GiB.
    pub images: Vec<(String, Bitmap)>,
    /// The number of objects that rays can hit. An instance of a mesh counts as one.
    pub primitives: u32,
    /// The scene's radiance is the device's radiance times 2 to this exponent.
    pub radiance_exponent: i32,
    /// The most radiance that a path carries from a surface or the background, in the scene's units.
    pub brightest: f64,
    /// The map from render space to the scene.
    pub space: SceneSpace,
    /// The frames around the one that is rendered, for motions; only if they are asked for.
    pub neighbours: Option<Arc<Neighbours>>,
    /// The pixels that lamps cover in part.
    pub lamps: Vec<data::LampPixel>,
    /// The largest radiance, in device units, of what is not sampled as a light.
    pub not_sampled: f64,
    /// Warnings about the scene, each with a location in the file, the number and a remedy.
    pub warnings: Vec<String>,
}

impl DeviceScene {
    /// The light paths of a render with these options: none if the scene has nothing to trace them to. `Auto` traces them to lights that BSDF
    /// sampling finds badly. It traces few: they reach all pixels, so that even one for eight camera paths of a pixel has little noise of its
    /// own. A light without size is found by light paths alone, so that more of them pay.
    pub fn light_paths(&self, options: &RenderOptions) -> LightPaths {
        match options.light_paths {
            _ if self.features.reason("light_paths").is_none() => LightPaths::Off,
            LightPaths::Auto if self.features.quantities.solid_angle_of_lights == 0.0 => {
                LightPaths::Count(PATHS_TO_DELTA_LIGHTS)
            }
            LightPaths::Auto if self.features.quantities.solid_angle_of_lights < LARGEST_SOLID_ANGLE => {
                LightPaths::Count(1)
            }
            LightPaths::Auto => LightPaths::Off,
            given => given,
        }
    }

    /// The channels of a render with these options.
    pub fn aovs(&self, options: &RenderOptions) -> Aovs {
        options.aov.of_groups(&self.light_groups)
    }

    /// The number of the group of this name.
    pub(super) fn group_of(&self, name: Option<&str>) -> u32 {
        let index = self.light_groups.iter().position(|group| Some(group.as_str()) == name);
        index.map_or(NO_GROUP, |index| index as u32)
    }

    /// Adds the groups of the rows of materials behind those of lights without size.
    pub(super) fn add_groups_of_materials(&mut self, scene: &Scene) {
        if self.light_groups.is_empty() {
            return;
        }
        self.features.quantities.delta_lights = self.delta_lights.len() as u32;
        let groups: HashMap<&str, u32> = { scene.materials.iter() }
            .map(|(name, material)| (name.as_str(), self.group_of(material.light_group())))
            .collect();
        let group = |name: &String| groups.get(name.as_str()).copied().unwrap_or(NO_GROUP);
        self.groups_of_lights.extend(self.material_names.iter().map(group));
    }

    /// The words of the buffer of texels, in parts: the table of sRGB codes if an image has them, then the images.
    pub fn texel_words(&self) -> impl Iterator<Item = &[u32]> {
        let has_codes = self.features.reason("texel.srgb").is_some();
        let table = has_codes.then(|| bytemuck::cast_slice(SRGB.as_slice()));
        table.into_iter().chain(self.images.iter().map(|(_, bitmap)| bitmap.words.as_slice()))
    }

    /// Appends a hierarchy to the table of nodes. Its primitives are numbered from `first_primitive` on. Returns the code of its root.
    pub(super) fn add_nodes(&mut self, bvh: &Bvh, first_primitive: u32) -> u32 {
        let first = self.nodes.len() as u32;
        let moved = |code: u32| match code {
            HIT_NOTHING => code,
            _ if code & PRIMITIVE_BIT == 0 => code + first,
            _ => code + first_primitive,
        };
        self.nodes.extend(bvh.nodes.iter().map(|node| data::Node { children: node.children.map(moved), ..*node }));
        moved(bvh.root)
    }

    /// Appends the hierarchy of a mesh, and the pairs of faces that are its leaves. Returns the code of its root.
    pub(super) fn add_mesh(&mut self, bvh: &Bvh, pairs: impl Iterator<Item = data::FacePair>) -> u32 {
        let root = self.add_nodes(bvh, self.face_pairs.len() as u32);
        self.face_pairs.extend(pairs);
        root
    }

    /// Appends the same with the children of a node beside each other: nodes, and pairs in place of nodes (shaders/scene/siblings). A node names the
    /// first of its children. Returns the place of the root.
    pub(super) fn add_siblings(&mut self, bvh: &Bvh, pairs: &[data::FacePair]) -> u32 {
        let root = self.nodes.len();
        let mut open = vec![(bvh.root, root)];
        self.nodes.push(data::Node::default());
        while let Some((code, place)) = open.pop() {
            self.nodes[place] = match code & PRIMITIVE_BIT {
                0 => {
                    let node = &bvh.nodes[code as usize];
                    let begin = self.nodes.len();
                    open.extend(node.children.into_iter().filter(|child| *child != HIT_NOTHING).zip(begin..));
                    self.nodes.resize(begin + node.grid[3].to_be_bytes()[0] as usize, data::Node::default());
                    data::Node { children: [begin as u32, 0, 0, 0], ..*node }
                }
                _ => {
                    let pair = pairs.get((code ^ primitive_code(KIND_TRIANGLE, 0)) as usize);
                    bytemuck::cast(pair.copied().unwrap_or_default())
                }
            };
        }
        root as u32
    }

    /// Fills the tables of features that the scene lacks, for kernels with all features: a light that is never chosen, a
    /// black sky.
    pub(super) fn require_all(&mut self, sample_lights: bool) {
        if sample_lights && self.sky.is_empty() {
            self.sky = vec![0; 4];
            self.lights.push(data::Light {
                code: data::HIT_NOTHING,
                instance: data::NO_INSTANCE,
                ..data::Light::default()
            });
        }
    }
}

//! Fills the tables of a scene for the kernels.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use glam::{DMat3, DVec3, Vec3};

use super::device_scene::DeviceScene;
use super::features::BACKGROUNDS;
use super::finder::{Finder, Primitive, WorldMedium};
use super::hierarchies::Hierarchies;
use super::mesh_tables::Table;
use super::motion::{Motion, in_space, similarity};
use super::motion_tables::{Motions, follows_nearest, order_of, row_of_boundary};
use super::swept::swept;
use crate::bitmap::Decoding;
use crate::bvh::{self, Bounds, Quality};
use crate::data::{self, NO_TEXTURE, f32s};
use crate::error::Result;
use crate::lobe::{LOBES, Rows};
use crate::material::{ALPHA, MIX, Material, Model, Slot, emission_row, microfacets};
use crate::options::Walk;
use crate::scene::{Background, Bitmap, Scene, SkyLayout, Step, Texture, Use};
use crate::shape::similarity::Similarity;
use crate::shape::{Element, KINDS, LargeSphere, MeshLayout, ObjectTransform, RenderSpace, Shape, error_bound, padded};
use crate::volume::grid::Grid;

/// The most primitives that every ray tests directly, without a hierarchy, if a ray hits at least `LEAST_CROSSINGS` of
/// their boxes on average (`bvh::crossings`), as in a room. Otherwise it is the number of children of a node. Measured
/// in docs/dev/performance.md.
const MOST_BY_BRUTE_FORCE: usize = 24;
const LEAST_CROSSINGS: f32 = 1.25;

/// Builds a `DeviceScene`.
pub struct Builder<'a> {
    pub scene: &'a Scene,
    pub space: RenderSpace,
    pub quality: Quality,
    pub walk: Walk,
    /// The numbers of the meshes that bound media.
    pub around_media: HashSet<usize>,
    /// The hierarchies of an earlier flattening, if there was one.
    pub hierarchies: Option<&'a mut Hierarchies>,
    /// The layouts of the meshes that have been added.
    pub layouts: Vec<Option<MeshLayout>>,
    /// The tables of texture coordinates of each mesh.
    pub tables: Vec<Vec<Table>>,
    /// The index in the table of each of the scene's materials that an object uses.
    pub materials: Vec<u32>,
    /// The properties of each of the scene's materials.
    pub models: Vec<Model<'a>>,
    /// The numbers of the materials that each of the scene's materials needs: its own, and those of its parts.
    pub needed: &'a [Vec<usize>],
    /// The slots of each of the scene's materials that have frames. On every object, each has its own frame, in this order.
    pub framed: Vec<Vec<Slot<'a>>>,
    /// Whether anything that it emits shows, for each of the scene's materials.
    pub shows_emission: Vec<bool>,
    /// The index of each image's first word, by path and decoding.
    pub images: HashMap<(String, Decoding), u32>,
    /// The first frames of meshes, by mesh and material.
    pub mesh_frames: HashMap<(usize, u32), u32>,
    /// The grids that have been added, each with the index of its first word.
    pub grids: Vec<(Arc<Grid>, u32)>,
    /// The index of the first word of the table of black bodies, if a medium needs it.
    pub heat: Option<u32>,
    /// The motions, if anything moves.
    pub motions: Option<Motions>,
    pub flat: DeviceScene,
}

impl Builder<'_> {
    /// Lays out all that the scene has, and its motions.
    ///
    /// # Errors
    /// `Error::Scene` if a grid is too large.
    pub fn add_objects(&mut self, finder: &Finder<'_>, sample_lights: bool, radiance_scale: f64) -> Result<()> {
        self.add_primitives(&finder.primitives);
        self.add_media(&finder.media, radiance_scale)?;
        if sample_lights && self.flat.features.samples_light_anywhere() {
            self.add_lights(&finder.primitives, &finder.lights, radiance_scale);
        }
        self.flat.motions = self.motions.take().map(Motions::into_rows).unwrap_or_default();
        Ok(())
    }

    /// Lays out the primitives and builds the hierarchy over them.
    pub fn add_primitives(&mut self, primitives: &[Primitive<'_>]) {
        let (codes, bounds): (Vec<_>, Vec<_>) =
            (0..).zip(primitives).map(|(order, primitive)| self.add_primitive(primitive, order)).unzip();
        let bvh = bvh::build(&bounds, &codes, self.quality);
        self.flat.primitives = primitives.len() as u32;
        let flat = &mut self.flat;
        let crowded = primitives.len() <= MOST_BY_BRUTE_FORCE && bvh::crossings(&bounds) >= LEAST_CROSSINGS;
        flat.features.quantities.brute_force =
            (primitives.len() <= bvh::WIDTH || crowded) && flat.shapes.instances.is_empty();
        // The number of primitives of each kind that the scene has, before boundaries of media are added.
        let counts = KINDS.iter().map(|kind| kind.table.count(&flat.shapes) as u32).filter(|count| *count > 0);
        let counts: Vec<u32> = counts.collect();
        let room = &mut flat.settings.brute_force;
        // Surfaces with an alpha are passed in the walk through the hierarchy alone.
        flat.features.quantities.brute_force &= counts.len() <= room.len() && flat.features.any("alpha").is_none();
        room.iter_mut().zip(counts).for_each(|(room, count)| *room = count);
        self.flat.settings.root = self.flat.add_nodes(&bvh, 0);
        // In a mesh, the walk keeps the nodes of the outer hierarchy on the stack.
        let within = self.layouts.iter().flatten().map(|mesh| mesh.stack_size).max().unwrap_or(0);
        self.flat.features.quantities.stack_size = (bvh.stack_size + within).max(1);
    }

    fn add_media(&mut self, media: &[WorldMedium<'_>], radiance_scale: f64) -> Result<()> {
        let mut centers = Vec::new();
        for (index, medium) in media.iter().enumerate() {
            let order = row_of_boundary(self.flat.primitives as usize, index) as u32;
            let order = order_of(order, &medium.motion);
            centers.push(self.add_medium(medium, order));
            let size = self.layout_of(&medium.boundary).stack_size;
            let deepest = &mut self.flat.features.quantities.boundary_stack_size;
            *deepest = size.max(*deepest);
        }
        self.flat.features.quantities.media = media.len() as u32;
        self.add_fields(media, &centers, radiance_scale)
    }

    /// Adds a primitive. Returns its code and its bounds.
    pub fn add_primitive(&mut self, primitive: &Primitive, order: u32) -> (u32, Bounds) {
        let Primitive { shape, to_world, material, .. } = primitive;
        let frame = self.frame_of(primitive);
        let material = self.materials[*material as usize];
        let order = order_of(order, &primitive.motion);
        let (index, rest) = self.add_shape(shape, to_world, Element { order, material, frame, ..Element::default() });
        if primitive.motion.is_empty() {
            return (shape.code(index), rest);
        }
        self.choose_own_point(shape, index, to_world, &primitive.motion);
        let bounds = self.bounds_of_way(primitive, rest);
        (shape.code(index), bounds)
    }

    /// Writes into a large sphere that moves which is its own point.
    pub fn choose_own_point(&mut self, shape: &Shape, index: usize, to_world: &Similarity, motion: &Motion) {
        let at = ObjectTransform { to_world, space: self.space };
        if shape.large_sphere().is_some()
            && let Some(element) = self.flat.shapes.large_spheres.get_mut(index)
        {
            element.follows_nearest = u32::from(follows_nearest(shape, &at, motion));
        }
    }

    /// The bounds of a primitive on all its way, with room for the rounding of its poses: as much as for that at rest, for each step.
    fn bounds_of_way(&self, primitive: &Primitive, rest: Bounds) -> Bounds {
        let at = ObjectTransform { to_world: &primitive.to_world, space: self.space };
        let steps = in_space(&primitive.motion, self.space);
        let shape = primitive.shape.bounding_shape(&at);
        let way = swept(&shape, &steps);
        let arms = steps.iter().map(|step| (shape.position() - step.center).length() as f32);
        let sizes = [way.min.as_vec3(), way.max.as_vec3(), Vec3::splat(arms.sum())];
        let room = error_bound(&sizes) * (1 + steps.len()) as f32;
        let (min, max) = padded(way.min.as_vec3(), way.max.as_vec3(), room);
        Bounds { min: min.min(rest.min), max: max.max(rest.max) }
    }

    /// Adds a shape of an object or of a medium's boundary. Returns its index among its kind, and its bounds.
    pub fn add_shape(&mut self, shape: &Shape, to_world: &Similarity, element: Element) -> (usize, Bounds) {
        let element = Element { layout: self.layout_of(shape), ..element };
        let tables = &mut self.flat.shapes;
        let (min, max) = shape.lay_out(&ObjectTransform { to_world, space: self.space }, element, tables);
        (shape.kind().table.count(tables) - 1, Bounds { min, max })
    }

    /// The layout of a mesh in the tables; the default for other shapes.
    pub fn layout_of(&mut self, shape: &Shape) -> MeshLayout {
        shape.mesh().map(|mesh| self.layout_of_mesh(mesh)).unwrap_or_default()
    }

    /// Adds a frame for the texture coordinates of each object, in the order of their numbers.
    pub fn add_frames_of_objects(&mut self, primitives: &[Primitive<'_>]) {
        let frame = |Primitive { shape, to_world, .. }: &Primitive<'_>| {
            let pole = shape.large_sphere().map_or(DVec3::ZERO, LargeSphere::outward);
            Texture::frame_of_coordinates(pole, &to_world.rotation)
        };
        self.flat.frames.extend(primitives.iter().map(frame));
    }

    /// The index of a primitive's first frame; 0 if its material has no texture.
    pub fn frame_of(&mut self, primitive: &Primitive) -> u32 {
        let Primitive { shape, to_world, material, .. } = primitive;
        let slots = &self.framed[*material as usize];
        if slots.is_empty() {
            return 0;
        }
        // All instances of a mesh share frames, because textures are evaluated in the mesh's own space.
        let shared = shape.mesh().map(|mesh| (mesh.number, *material));
        if let Some(&frame) = shared.and_then(|key| self.mesh_frames.get(&key)) {
            return frame;
        }
        let space = shape.texture_frame(&to_world.rotation);
        let index = self.flat.frames.len() as u32;
        // Texture coordinates of a large sphere are relative to its nearest point, and those of a sphere to its centre.
        let pole = shape.large_sphere().map_or(DVec3::ZERO, LargeSphere::outward);
        let frames = slots.iter().filter_map(|slot| {
            let frame = slot.texture.frame(slot.usage, space, (pole, &to_world.rotation))?;
            let mesh = shape.mesh().filter(|_| slot.texture.needs_uv() || slot.usage == Use::Direction);
            Some(mesh.map_or(frame, |mesh| data::Frame { phase: self.phase_on(slot, mesh), ..frame }))
        });
        let frames: Vec<_> = frames.collect();
        self.flat.frames.extend(frames);
        if let Some(key) = shared {
            self.mesh_frames.insert(key, index);
        }
        index
    }

    pub fn add_background(&mut self, radiance_scale: f64, to_space: &Similarity) {
        let scene = self.scene;
        let settings = &mut self.flat.settings;
        let kind = background_kind(&scene.background);
        settings.background = kind as u32;
        self.flat.features.require(format!("background.{}", BACKGROUNDS[kind]), || {
            format!("background at {}", scene.location(&[Step::Field("background")]))
        });
        match &scene.background {
            Background::Solid(colour) => {
                settings.background_bottom = f32s(radiance_scale * *colour);
            }
            Background::Gradient { bottom, top } => {
                settings.background_bottom = f32s(radiance_scale * *bottom);
                settings.background_top = f32s(radiance_scale * *top);
            }
            Background::Image { path, tint, by, .. } => {
                let DMat3 { x_axis, y_axis, z_axis } = to_space.rotation * similarity(by).rotation;
                [settings.world_x, settings.world_y, settings.world_z] = [x_axis, y_axis, z_axis].map(f32s);
                if similarity(by).rotation != DMat3::IDENTITY {
                    let at = scene.location(&[Step::Field("background"), Step::Field("by")]);
                    self.flat.features.require("camera_axes", || format!("background.by at {at}"));
                }
                settings.background_bottom = f32s(radiance_scale * *tint);
                if let Some(bitmap) = scene.bitmaps.colours(path) {
                    settings.background_width = bitmap.width;
                    settings.background_height = bitmap.height;
                    settings.background_format = bitmap.format.number() as u32;
                    self.flat.settings.background_texel = self.add_image(path, Decoding::Colour, bitmap);
                }
            }
        }
    }

    /// Adds the materials that objects use.
    pub fn add_materials(&mut self, used: &[bool], radiance_scale: f64) {
        let scene = self.scene;
        for (number, (name, material)) in scene.materials.iter().enumerate().filter(|(number, _)| used[*number]) {
            let Model { slot, on_device, second_part, .. } = self.models[number];
            let row = data::Material { kind: material.number_on_device() as u32, ..on_device };
            self.materials[number] = self.flat.materials.len() as u32;
            self.add_row(name, row, slot, radiance_scale);
            if let Some(second) = second_part {
                self.add_row(name, second, None, radiance_scale);
            }
        }
    }

    /// Adds a row of the table of materials.
    pub fn add_row(&mut self, name: &str, mut row: data::Material, slot: Option<Slot<'_>>, radiance_scale: f64) {
        row.texture = NO_TEXTURE;
        if let Some(slot) = slot {
            let brightness = match slot.usage {
                Use::Radiance => radiance_scale,
                Use::Albedo | Use::Tint | Use::Share | Use::Normal | Use::Direction => 1.0,
            };
            row.colour = slot.texture.plain().map_or([0.0; 3], |colour| f32s(brightness * colour));
            row.texture = self.add_texture(slot.texture, brightness);
        }
        self.flat.materials.push(row);
        self.flat.material_names.push(name.to_owned());
    }

    /// Adds the tables of directional albedos that materials need. `everything`: all of them.
    pub fn add_directional_albedos(&mut self, used: &[bool], everything: bool) {
        let has = |fact| self.flat.features.any(fact).is_some() || everything;
        // The table of a lobe stands behind that of metals.
        let tables: Vec<_> = LOBES.iter().filter(|lobe| has(lobe.name())).filter_map(|lobe| lobe.table).collect();
        if has("multiscatter") || !tables.is_empty() {
            self.flat.directional_albedos = microfacets::directional_albedos().to_vec();
        }
        tables.iter().for_each(|table| self.flat.directional_albedos.extend(table()));
        let mut begins = HashMap::new();
        for (number, (_, material)) in self.scene.materials.iter().enumerate().filter(|(number, _)| used[*number]) {
            let Material::Plastic(plastic) = material else { continue };
            let layer = plastic.layer();
            let (leaving, table) = &*layer;
            let tables = &mut self.flat.directional_albedos;
            let begin = *begins.entry(Arc::as_ptr(&layer)).or_insert_with(|| {
                let begin = 4 * tables.len();
                tables.extend(table.chunks_exact(4).map(|four| [0, 1, 2, 3].map(|i| four[i] as f32)));
                begin
            });
            let index = self.materials[number] as usize;
            self.flat.materials[index].numbers[2] = *leaving as f32;
            self.flat.materials[index + 1].numbers[1] = begin as f32;
        }
    }

    /// Adds the further rows of materials, behind those of all materials. The emission of a light has such a row too, so that kernels
    /// treat all emitters alike.
    pub fn add_extensions(&mut self, used: &[bool], radiance_scale: f64) {
        let scene = self.scene;
        let mut extensions = vec![Rows::NONE; self.flat.materials.len()];
        for (number, (name, _)) in scene.materials.iter().enumerate().filter(|(number, _)| used[*number]) {
            let model = &self.models[number];
            let light = model.light().map(|light| emission_row(light.slot, light.two_sided));
            let mut own = Rows::NONE;
            own.absorption = f32s(model.absorption.unwrap_or_default() / self.space.scale);
            // The frames of the surface are those of the material's textures in their order. The emission of a light is its only one.
            let mut frame = if light.is_some() { 0 } else { model.slot.map_or(0, |slot| u32::from(slot.has_frame())) };
            let rows: Vec<_> = model.rows.iter().copied().chain(light).collect();
            for mut row in rows {
                if let (MIX, [_, a, b]) = (row.kind, &self.needed[number][..]) {
                    let frames = self.framed[*a].len() as u32;
                    row.numbers = [self.materials[*a], self.materials[*b], frames].map(|number| number as f32);
                }
                own.set(row.kind, self.flat.materials.len() as u32);
                let on_device = data::Material { kind: frame, numbers: row.numbers, ..data::Material::default() };
                frame += u32::from(row.slot.has_frame());
                self.flat.features.quantities.alpha_textures |= row.slot.is_textured() && row.kind == ALPHA;
                // An emission that no coverage shows may be too bright for f32 in the unit of those that show.
                let brightness = if self.shows_emission[number] { radiance_scale } else { 0.0 };
                self.add_row(name, on_device, Some(row.slot), brightness);
            }
            if let Some(extensions) = extensions.get_mut(self.materials[number] as usize) {
                *extensions = own;
            }
        }
        self.flat.extensions = extensions;
    }

    /// The index of an image's first word. An image is stored once, however often it is used.
    pub fn add_image(&mut self, path: &str, decoding: Decoding, bitmap: &Bitmap) -> u32 {
        let key = (path.to_string(), decoding);
        if let Some(&first) = self.images.get(&key) {
            return first;
        }
        let first = self.flat.texel_words().map(<[u32]>::len).sum::<usize>() as u32;
        self.flat.images.push((path.to_string(), bitmap.clone()));
        self.images.insert(key, first);
        first
    }

    /// Adds a texture. Returns its number, or `NO_TEXTURE` for a plain colour.
    pub fn add_texture(&mut self, texture: &Texture, brightness: f64) -> u32 {
        let scene = self.scene;
        let flat =
            texture.upload(brightness, &scene.bitmaps, |path, decoding, bitmap| self.add_image(path, decoding, bitmap));
        let Some(flat) = flat else { return NO_TEXTURE };
        self.flat.textures.push(flat);
        self.flat.textures.len() as u32 - 1
    }
}

/// The index in `BACKGROUNDS`.
fn background_kind(background: &Background) -> usize {
    match background {
        Background::Solid(_) => 0,
        Background::Gradient { .. } => 1,
        Background::Image { layout: SkyLayout::LatitudeLongitude, .. } => 2,
        Background::Image { layout: SkyLayout::Octahedral, .. } => 3,
    }
}

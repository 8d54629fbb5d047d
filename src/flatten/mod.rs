//! Converts the scene, in f64 and scene units, to the arrays that the kernels read, in f32 and render space.
//!
//! Render space has the camera at the origin and is scaled by a power of two to an extent near 1, so that kernels see the
//! same numbers whatever the size and the position of the scene. If pixels are very narrow, it has the camera's axes
//! (`view`). Emission is also scaled by a power of two.

mod cuts;
mod diagnostics;
mod features;
mod hierarchies;
mod light_tree;
mod lights;
mod media;
mod meshes;
mod pairs;
mod place;
mod tangents;
mod view;

use std::collections::{HashMap, HashSet};

use glam::DVec3;

use crate::aov::SceneSpace;
use crate::bitmap::{Decoding, Format, SRGB};
use crate::bvh::{self, Bounds};
use crate::data::{self, MAX_PRIMITIVES, NO_TEXTURE, f32s};
use crate::delta_light::PlacedLight;
use crate::error::{Error, Result};
use crate::material::{Extension, ExtensionKind, Lobe, Slot, microfacets};
use crate::options::{FeatureSet, Integrator, RenderOptions};
use crate::scene::{Background, Bitmap, Material, Object, Scene, Step, Texture, Use};
use crate::shape::mesh::{self, Laid};
use crate::shape::similarity::Similarity;
use crate::shape::{Element, Hull, KINDS, LargeSphere, Placement, RenderSpace, Shape, Tables, binary_exponent, exp2};
use crate::threads::beside;
use diagnostics::Search;
use place::{Finder, Placed, PlacedMedium, extent};
use view::View;

pub use crate::material::MATERIALS;
pub use crate::texture::TEXTURES;
pub use bvh::Quality;
pub use features::{BACKGROUNDS, BOUNDARIES, EVERY_FEATURE, Features, NotSampled, PRIMITIVES};
pub use hierarchies::Hierarchies;
pub use lights::MOST_LIGHTS;

/// A walk keeps six bits beside the index of a node whose children wait (shaders/scene/traverse). So many nodes take 4 GiB.
const MAX_NODES: usize = 1 << 26;

/// A scene as the kernels see it.
#[derive(Clone, Debug, Default)]
pub struct DeviceScene {
    pub features: Features,
    /// The camera, the background and the BVH's root. The render fills in the other settings.
    pub settings: data::Settings,
    pub nodes: Vec<data::Node>,
    pub shapes: Tables,
    /// Faces, vertices and texture coordinates of all meshes, in the layout of shaders/bind/meshes.
    pub meshes: Vec<[u32; 4]>,
    /// The leaves of the meshes' hierarchies.
    pub face_pairs: Vec<data::FacePair>,
    pub media: Vec<data::Medium>,
    pub lights: Vec<data::Light>,
    pub delta_lights: Vec<data::DeltaLight>,
    /// The tree over the lights; empty if there are fewer than two.
    pub light_nodes: Vec<data::LightNode>,
    /// The distribution of directions by the background's image.
    pub sky: Vec<data::SkyCell>,
    pub materials: Vec<data::Material>,
    /// Where a material has extensions, those of each row of `materials`.
    pub extensions: Vec<data::Extension>,
    /// Where a material asks for it, what single scattering by microfacets keeps of light.
    pub kept_shares: Vec<[f32; 4]>,
    /// The names in the scene file of the rows of `materials`.
    pub material_names: Vec<String>,
    pub textures: Vec<data::Texture>,
    pub frames: Vec<data::Frame>,
    /// The images, in the order of their texels, each with its path. The texels are the scene's own: a copy may take 2 GiB.
    pub images: Vec<(String, Bitmap)>,
    /// The number of objects that rays can hit. An instance of a mesh counts as one.
    pub primitives: u32,
    /// The scene's radiance is the device's radiance times 2 to this power.
    pub radiance_exponent: i32,
    /// Render space in the scene.
    pub space: SceneSpace,
    /// Warnings about the placed scene, each with a location in the file, the number and a remedy.
    pub warnings: Vec<String>,
}

/// The most media. Each takes one of the loop iterations that an invocation is allowed (shaders/stage/bounce).
const MOST_MEDIA: usize = 1024;

/// The most primitives that every ray tests directly, without a hierarchy, if a ray hits at least `LEAST_CROSSINGS` of
/// their boxes on average (`bvh::crossings`), as in a room. Otherwise it is the number of children of a node. Measured
/// in docs/performance.md.
const MOST_BY_BRUTE_FORCE: usize = 24;
const LEAST_CROSSINGS: f32 = 1.25;

/// Flattens a scene for an image of `size` pixels. It reads only the options that change tables: the integrator, the build of the
/// hierarchies, and the features.
///
/// # Errors
/// `Error::Scene` if there are more primitives or nodes than codes can number, or more media than a ray can cross.
pub fn flatten(scene: &Scene, size: (u32, u32), options: &RenderOptions) -> Result<DeviceScene> {
    flatten_with(scene, size, options, None)
}

/// Flattens a scene that may have been flattened before, with the hierarchies that were built then.
///
/// # Errors
/// The errors of [`flatten`].
pub fn flatten_again(
    scene: &Scene,
    size: (u32, u32),
    options: &RenderOptions,
    hierarchies: &mut Hierarchies,
) -> Result<DeviceScene> {
    hierarchies.keep_those_of(scene);
    flatten_with(scene, size, options, Some(hierarchies))
}

fn flatten_with(
    scene: &Scene,
    size: (u32, u32),
    options: &RenderOptions,
    hierarchies: Option<&mut Hierarchies>,
) -> Result<DeviceScene> {
    let mut features = Features::default();
    let meshes = mesh::shapes(&scene.meshes);
    let view = View::new(&scene.camera, size);
    let mut finder = Finder::new(scene, &meshes, view.eye);
    scene.objects.iter().for_each(|object| finder.place(object, &view.to_space));
    for (primitive, object) in finder.placed.iter().zip(&finder.objects) {
        require_primitive(&mut features, scene, object, primitive);
        if primitive.shape.mesh().is_some_and(|shape| !shape.mesh.normals.is_empty()) {
            features.smooth.get_or_insert_with(|| scene.location_of(object).to_string());
        }
    }
    // Whether an object uses each material.
    let mut used = vec![false; scene.materials.len()];
    for primitive in &finder.placed {
        let number = primitive.material as usize;
        if !std::mem::replace(&mut used[number], true) {
            let (name, material) = &scene.materials[number];
            require_material(&mut features, scene, name, material);
        }
    }
    finder.media.iter().for_each(|medium| require_medium(&mut features, scene, medium));
    if let Background::Image { path } = &scene.background
        && let Some(bitmap) = scene.bitmaps.colours(path)
    {
        let at = scene.location(&[Step::Field("background")]);
        require_format(&mut features, bitmap, || format!("background at {at}"));
    }
    let faces: usize = scene.meshes.values().map(|mesh| mesh.triangles.len() + mesh.positions.len() * 2).sum();
    let most = finder.placed.len().max(faces);
    if most >= MAX_PRIMITIVES {
        return Err(scene.error(&[], format!("expected fewer than {MAX_PRIMITIVES} primitives, found {most}")));
    }
    if finder.media.len() > MOST_MEDIA {
        let message = format!("expected at most {MOST_MEDIA} media, found {}", finder.media.len());
        return Err(scene.error(&[], message));
    }
    if let Some((object, _)) = finder.lights.first()
        && options.integrator == Integrator::Bsdf
    {
        return Err(no_chance(scene, object));
    }
    if finder.lights.len() >= MOST_LIGHTS {
        let message = format!("expected fewer than {MOST_LIGHTS} lights without size, found {}", finder.lights.len());
        return Err(scene.error(&[], message));
    }

    let extent = extent(view.eye, view.lens_radius(), &finder);
    let brightest = brightest(scene, &used).max(brightest_shown(&finder, view.eye, extent));
    let search = Search::new(scene, &finder, &view, extent, brightest > 0.0);
    let length_exponent = binary_exponent(extent);
    let space = RenderSpace { eye: view.eye, scale: exp2(-length_exponent) };
    let radiance_exponent = binary_exponent(if brightest > 0.0 { brightest } else { 1.0 });
    let radiance_scale = exp2(-radiance_exponent);

    let to_scene = SceneSpace::new(scene.camera.look_from, view.to_space.rotation.transpose(), length_exponent);
    let mut flat = DeviceScene { features, radiance_exponent, space: to_scene, ..DeviceScene::default() };
    if brightest == 0.0 {
        let at = scene.location(&[Step::Field("background")]);
        flat.warnings.push(format!(
            "{at}: background: nothing in this scene emits light, so that the image is black: give the background a colour, or an \
             object a DiffuseLight"
        ));
    }
    flat.settings = view.settings(&space);
    let mut builder = Builder {
        scene,
        laid: vec![None; meshes.len()],
        tables: vec![vec![meshes::Table::FIRST]; meshes.len()],
        space,
        quality: options.build,
        around_media: finder.media.iter().filter_map(|medium| medium.boundary.mesh()).map(|mesh| mesh.number).collect(),
        hierarchies,
        materials: vec![0; scene.materials.len()],
        textures: scene.materials.iter().map(|(_, material)| material.textures()).collect(),
        images: HashMap::new(),
        mesh_frames: HashMap::new(),
        flat,
    };
    builder.find_tables(&finder.placed);
    builder.add_background(radiance_scale);
    builder.add_materials(&used, radiance_scale);
    if builder.flat.features.has_extensions() || options.features == FeatureSet::All {
        builder.add_details(&used, radiance_scale);
    }
    if builder.flat.features.has_extension(ExtensionKind::Multiscatter) || options.features == FeatureSet::All {
        builder.flat.kept_shares = microfacets::kept_shares();
    }
    let sample_lights = options.integrator == Integrator::Mis;
    // The warnings are searched for while the hierarchies are built.
    let (warnings, ()) = beside(
        || search.warnings(),
        || {
            builder.add_primitives(&finder.placed);
            builder.add_media(&finder.media);
            if sample_lights && builder.flat.features.samples_light_anywhere() {
                builder.add_lights(&finder.placed, &finder.lights, radiance_scale);
            }
        },
    );
    let mut flat = builder.flat;
    if flat.meshes.len() >= MAX_PRIMITIVES {
        let message = format!(
            "expected fewer than {MAX_PRIMITIVES} faces, vertices and texture coordinates of meshes, found {}",
            flat.meshes.len()
        );
        return Err(scene.error(&[], message));
    }
    if flat.nodes.len() >= MAX_NODES {
        let message = format!("expected fewer than {MAX_NODES} nodes in the hierarchies, found {}", flat.nodes.len());
        return Err(scene.error(&[], message));
    }
    flat.warnings.extend(warnings);
    flat.warnings.extend(stopped_by_glass(scene, &finder, &flat.features));
    flat.features.shadow_rays = flat.features.lights > 0;
    let of_camera =
        |field: &str| format!("camera.{field} at {}", scene.location(&[Step::Field("camera"), Step::Field(field)]));
    flat.features.thin_lens = (scene.camera.aperture > 0.0).then(|| of_camera("aperture"));
    flat.features.turned = view.turned.then(|| of_camera("vertical_fov"));
    if options.features == FeatureSet::All {
        flat.require_all(sample_lights);
    }
    Ok(flat)
}

/// A scene on its way to a `DeviceScene`.
struct Builder<'a> {
    scene: &'a Scene,
    space: RenderSpace,
    quality: Quality,
    /// The numbers of the meshes that bound media.
    around_media: HashSet<usize>,
    /// The hierarchies of an earlier flattening, if there was one.
    hierarchies: Option<&'a mut Hierarchies>,
    /// The meshes that have been laid out.
    laid: Vec<Option<Laid>>,
    /// The tables of each mesh beside its vertices.
    tables: Vec<Vec<meshes::Table>>,
    /// The index in the table of each of the scene's materials that an object uses.
    materials: Vec<u32>,
    /// The textures of each of the scene's materials that are no plain colour. On every object they have frames of their own, one behind
    /// the other.
    textures: Vec<Vec<&'a Texture>>,
    /// The place of each image's first word, by path and decoding.
    images: HashMap<(String, Decoding), u32>,
    /// The first frames of meshes, by mesh and material.
    mesh_frames: HashMap<(usize, u32), u32>,
    flat: DeviceScene,
}

impl Builder<'_> {
    /// Lays out the primitives and builds the hierarchy over them.
    fn add_primitives(&mut self, placed: &[Placed<'_>]) {
        let (codes, bounds): (Vec<_>, Vec<_>) =
            (0..).zip(placed).map(|(order, primitive)| self.add_primitive(primitive, order)).unzip();
        let bvh = bvh::build(&bounds, &codes, self.quality);
        self.flat.primitives = placed.len() as u32;
        let flat = &mut self.flat;
        let crowded = placed.len() <= MOST_BY_BRUTE_FORCE && bvh::crossings(&bounds) >= LEAST_CROSSINGS;
        flat.features.brute_force = (placed.len() <= bvh::WIDTH || crowded) && flat.shapes.instances.is_empty();
        // The number of primitives of each kind that the scene has, before boundaries of media are added.
        let counts = KINDS.iter().map(|kind| kind.table.count(&flat.shapes) as u32).filter(|count| *count > 0);
        let counts: Vec<u32> = counts.collect();
        let room = &mut flat.settings.brute_force;
        // Surfaces with an alpha are passed in the walk through the hierarchy alone.
        flat.features.brute_force &= counts.len() <= room.len() && !flat.features.has_extension(ExtensionKind::Alpha);
        room.iter_mut().zip(counts).for_each(|(room, count)| *room = count);
        self.flat.settings.root = self.flat.add_nodes(&bvh, 0);
        // In a mesh, the walk keeps the nodes of the outer hierarchy on the stack.
        let within = self.laid.iter().flatten().map(|mesh| mesh.stack_size).max().unwrap_or(0);
        self.flat.features.stack_size = (bvh.stack_size + within).max(1);
    }

    fn add_media(&mut self, media: &[PlacedMedium<'_>]) {
        for medium in media {
            self.add_medium(medium);
            let size = self.laid_of(&medium.boundary).stack_size;
            let features = &mut self.flat.features;
            features.boundary_stack_size = features.boundary_stack_size.max(size);
        }
        self.flat.features.media = media.len() as u32;
    }

    /// Adds a primitive. Returns its code and its bounds.
    fn add_primitive(&mut self, primitive: &Placed, order: u32) -> (u32, Bounds) {
        let Placed { shape, to_world, material } = primitive;
        let frame = self.frame_of(primitive);
        let material = self.materials[*material as usize];
        let (index, bounds) = self.add_shape(shape, to_world, Element { order, material, frame, ..Element::default() });
        (shape.code(index), bounds)
    }

    /// Adds a shape of an object or of a medium's boundary. Returns its index among its kind, and its bounds.
    fn add_shape(&mut self, shape: &Shape, to_world: &Similarity, element: Element) -> (usize, Bounds) {
        let element = Element { laid: self.laid_of(shape), ..element };
        let tables = &mut self.flat.shapes;
        let (min, max) = shape.lay_out(&Placement { to_world, space: self.space }, element, tables);
        (shape.kind().table.count(tables) - 1, Bounds { min, max })
    }

    /// The place of a mesh in the tables; the default for other shapes.
    fn laid_of(&mut self, shape: &Shape) -> Laid {
        shape.mesh().map(|mesh| self.laid(mesh)).unwrap_or_default()
    }

    /// The index of a primitive's first frame; 0 if its material has no texture.
    fn frame_of(&mut self, primitive: &Placed) -> u32 {
        let Placed { shape, to_world, material } = primitive;
        let textures = &self.textures[*material as usize];
        if textures.is_empty() {
            return 0;
        }
        // All instances of a mesh share frames, because textures are evaluated in the mesh's own space.
        let shared = shape.mesh().map(|mesh| (mesh.number, *material));
        if let Some(&frame) = shared.and_then(|key| self.mesh_frames.get(&key)) {
            return frame;
        }
        let place = shape.texture_place(&to_world.rotation);
        let index = self.flat.frames.len() as u32;
        // Texture coordinates of a large sphere are relative to its nearest point, and those of a sphere to its centre.
        let pole = shape.large_sphere().map_or(DVec3::ZERO, LargeSphere::outward);
        let frames = textures.iter().filter_map(|texture| {
            let frame = texture.frame(place, (pole, &to_world.rotation))?;
            let mesh = shape.mesh().filter(|_| texture.image().is_some());
            Some(mesh.map_or(frame, |mesh| data::Frame { phase: self.table_of(texture, mesh) as f32, ..frame }))
        });
        let frames: Vec<_> = frames.collect();
        self.flat.frames.extend(frames);
        if let Some(key) = shared {
            self.mesh_frames.insert(key, index);
        }
        index
    }
}

/// Records the features that a primitive requires.
fn require_primitive(features: &mut Features, scene: &Scene, object: &Object, primitive: &Placed<'_>) {
    features.primitives[primitive.shape.number()].get_or_insert_with(|| scene.location_of(object).to_string());
}

/// Records the features that a material on an object requires.
fn require_material(features: &mut Features, scene: &Scene, name: &str, material: &Material) {
    let at_material = || format!("\"{name}\" at {}", scene.material_location(name));
    let number = material.number();
    features.materials[number].get_or_insert_with(at_material);
    let model = material.model();
    for lobe in material.lobes(&scene.bitmaps) {
        let kinds = match lobe {
            Lobe::Wide => &mut features.non_specular,
            Lobe::Narrow => &mut features.narrow,
            Lobe::Specular => &mut features.specular,
        };
        kinds[number].get_or_insert_with(at_material);
        if lobe == Lobe::Narrow {
            features.non_specular[number].get_or_insert_with(at_material);
        }
    }
    if material.kind().is_transmissive && model.slot.is_some() {
        features.tinted[number].get_or_insert_with(at_material);
    }
    if model.absorption.is_some() {
        features.absorbing[number].get_or_insert_with(at_material);
    }
    for extension in &model.extensions {
        features.extensions[extension.kind as usize][number].get_or_insert_with(at_material);
    }
    for kind in model.slots().filter_map(|slot| slot.texture.shader_number()) {
        features.textures[kind].get_or_insert_with(at_material);
    }
    for bitmap in model.slots().filter_map(|slot| slot.texture.bitmap(&scene.bitmaps)) {
        require_format(features, bitmap, at_material);
    }
}

/// Records the format that an image requires.
fn require_format(features: &mut Features, bitmap: &Bitmap, asked_by: impl FnOnce() -> String) {
    features.texel_formats[bitmap.format.number()].get_or_insert_with(asked_by);
}

/// Records the features that a medium requires.
fn require_medium(features: &mut Features, scene: &Scene, medium: &PlacedMedium<'_>) {
    let kind = medium.boundary.code_kind();
    let at_object = || scene.location_of(medium.object).to_string();
    let place = BOUNDARIES.iter().position(|(_, number)| *number == kind);
    if let Some(slot) = place.and_then(|place| features.boundaries.get_mut(place)) {
        slot.get_or_insert_with(at_object);
    }
    // The width is that of width_of_phase (shaders/medium/phase_pdf).
    if Lobe::of_width((3f64.sqrt() * (1.0 - medium.anisotropy.abs())) as f32) == Lobe::Narrow {
        features.narrow_media.get_or_insert_with(at_object);
    }
    if let Some(kind) = medium.albedo.shader_number() {
        features.textures[kind].get_or_insert_with(at_object);
        features.textured_media.get_or_insert_with(at_object);
    }
}

/// The error that `--integrator bsdf` cannot find a light.
fn no_chance(scene: &Scene, object: &Object) -> Error {
    let name = object.name();
    let message = format!(
        "a {name} has no size, so that no path can hit it: --integrator bsdf finds no light of it. Use --integrator mis, or a small sphere \
         with a DiffuseLight in its place"
    );
    scene.error_of(object, &message)
}

/// The warning that mirrors or glass stop the light of lights without size, which BSDF sampling cannot hit.
fn stopped_by_glass(scene: &Scene, finder: &Finder<'_>, features: &Features) -> Option<String> {
    let (object, _) = finder.lights.first()?;
    let shiny = features.specular.iter().flatten().next()?;
    if !features.samples_light_anywhere() {
        return None;
    }
    let more = match finder.lights.len() {
        1 => String::new(),
        n => format!(" (and {} more like it)", n - 1),
    };
    Some(format!(
        "{}: this {} has no size, so that no path finds it by a mirror or through glass ({shiny}): the light that they pass on from it is \
         missing in the image. A small sphere with a DiffuseLight brings it back, as noise{more}",
        scene.location_of(object),
        object.name(),
    ))
}

/// How many lights without size are looked at for the unit of radiance: the brightest.
const MOST_SHOWN: usize = 64;
/// The least distance of a light from what it lights, as a share of the scene's extent.
const LEAST_SHOWN: f64 = 1.0 / (1u64 << 14) as f64;

/// The largest radiance that a white diffuse surface has by a light without size, about: at the nearest hull of an object.
fn brightest_shown(finder: &Finder<'_>, eye: DVec3, extent: f64) -> f64 {
    let space = RenderSpace { eye, scale: 1.0 };
    let mut lights: Vec<_> = finder.lights.iter().map(|(_, light)| light).collect();
    lights.sort_by(|a, b| b.colour.max_element().total_cmp(&a.colour.max_element()));
    let placed = finder.placed.iter().map(|placed| placed.shape.hull(&Placement { to_world: &placed.to_world, space }));
    let media =
        finder.media.iter().map(|medium| medium.boundary.hull(&Placement { to_world: &medium.to_world, space }));
    let hulls: Vec<Hull> = if lights.is_empty() { Vec::new() } else { placed.chain(media).collect() };
    let shown = |light: &PlacedLight| {
        let distance = light.place.map_or(1.0, |place| {
            let nearest = hulls.iter().map(|hull| hull.distance(place - eye)).fold(f64::INFINITY, f64::min);
            let nearest = if nearest.is_finite() { nearest } else { extent };
            nearest.max(LEAST_SHOWN * extent)
        });
        light.shown(distance)
    };
    lights.into_iter().take(MOST_SHOWN).map(shown).fold(0.0, f64::max)
}

/// The largest component of the radiance of the background and of the materials that objects have.
fn brightest(scene: &Scene, used: &[bool]) -> f64 {
    let sky = match &scene.background {
        Background::Solid(colour) => colour.max_element(),
        Background::Gradient { bottom, top } => bottom.max(*top).max_element(),
        Background::Image { path } => scene.bitmaps.colours(path).map_or(0.0, |bitmap| bitmap.brightest(DVec3::ONE)),
    };
    let used = scene.materials.iter().zip(used).filter(|(_, used)| **used);
    let emitted =
        used.filter_map(|((_, material), _)| Some(material.model().emission()?.slot.texture.brightest(&scene.bitmaps)));
    emitted.fold(sky, f64::max)
}

/// The index in `BACKGROUNDS`.
fn background_kind(background: &Background) -> usize {
    match background {
        Background::Solid(_) => 0,
        Background::Gradient { .. } => 1,
        Background::Image { .. } => 2,
    }
}

impl Builder<'_> {
    fn add_background(&mut self, radiance_scale: f64) {
        let scene = self.scene;
        let settings = &mut self.flat.settings;
        let kind = background_kind(&scene.background);
        settings.background = kind as u32;
        self.flat.features.backgrounds[kind] =
            Some(format!("background at {}", scene.location(&[Step::Field("background")])));
        match &scene.background {
            Background::Solid(colour) => {
                settings.background_bottom = f32s(radiance_scale * *colour);
            }
            Background::Gradient { bottom, top } => {
                settings.background_bottom = f32s(radiance_scale * *bottom);
                settings.background_top = f32s(radiance_scale * *top);
            }
            Background::Image { path } => {
                settings.background_bottom = [radiance_scale as f32; 3];
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
    fn add_materials(&mut self, used: &[bool], radiance_scale: f64) {
        let scene = self.scene;
        for (number, (name, material)) in scene.materials.iter().enumerate().filter(|(number, _)| used[*number]) {
            let model = material.model();
            let row = data::Material { kind: material.number() as u32, ..model.on_device };
            self.materials[number] = self.flat.materials.len() as u32;
            self.add_row(name, row, model.slot, radiance_scale);
            if let Some(second) = model.second_part {
                self.add_row(name, second, None, radiance_scale);
            }
        }
    }

    /// Adds a row of the table of materials.
    fn add_row(&mut self, name: &str, mut row: data::Material, slot: Option<Slot<'_>>, radiance_scale: f64) {
        row.texture = NO_TEXTURE;
        if let Some(slot) = slot {
            let brightness = match slot.usage {
                Use::Radiance => radiance_scale,
                Use::Albedo | Use::Share | Use::Normal => 1.0,
            };
            row.colour = slot.texture.plain().map_or([0.0; 3], |colour| f32s(brightness * colour));
            row.texture = self.add_texture(slot.texture, brightness);
        }
        self.flat.materials.push(row);
        self.flat.material_names.push(name.to_owned());
    }

    /// Adds what materials have beside their rows: rows behind those of all materials. The emission of a light has one too, since a
    /// kernel asks all emitters alike.
    fn add_details(&mut self, used: &[bool], radiance_scale: f64) {
        let scene = self.scene;
        let mut extensions = vec![data::Extension::NONE; self.flat.materials.len()];
        for (number, (name, material)) in scene.materials.iter().enumerate().filter(|(number, _)| used[*number]) {
            let model = material.model();
            let light = model.light().map(|light| Extension::emission(light.slot, light.two_sided));
            let is_textured = |slot: Slot| u32::from(slot.texture.plain().is_none());
            let mut own = data::Extension::NONE;
            own.absorption = f32s(model.absorption.unwrap_or_default() / self.space.scale);
            // The frames of the surface are those of the material's textures in their order. The emission of a light is its only one.
            let mut frame = if light.is_some() { 0 } else { model.slot.map_or(0, is_textured) };
            for extension in model.extensions.iter().copied().chain(light) {
                *extension.kind.row_of(&mut own) = self.flat.materials.len() as u32;
                let row = data::Material { kind: frame, parameter: extension.parameter, ..data::Material::default() };
                frame += is_textured(extension.slot);
                self.add_row(name, row, Some(extension.slot), radiance_scale);
            }
            if let Some(extensions) = extensions.get_mut(self.materials[number] as usize) {
                *extensions = own;
            }
        }
        self.flat.extensions = extensions;
    }

    /// The place of an image's first word. An image is stored once, however often it is used.
    fn add_image(&mut self, path: &str, decoding: Decoding, bitmap: &Bitmap) -> u32 {
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
    fn add_texture(&mut self, texture: &Texture, brightness: f64) -> u32 {
        let scene = self.scene;
        let flat =
            texture.upload(brightness, &scene.bitmaps, |path, decoding, bitmap| self.add_image(path, decoding, bitmap));
        let Some(flat) = flat else { return NO_TEXTURE };
        self.flat.textures.push(flat);
        self.flat.textures.len() as u32 - 1
    }
}

impl DeviceScene {
    /// The words of the buffer of texels, in parts: the table of sRGB codes if an image has them, then the images.
    pub fn texel_words(&self) -> impl Iterator<Item = &[u32]> {
        let has_codes = self.features.texel_formats[Format::Srgb.number()].is_some();
        let table = has_codes.then(|| bytemuck::cast_slice(SRGB.as_slice()));
        table.into_iter().chain(self.images.iter().map(|(_, bitmap)| bitmap.words.as_slice()))
    }

    fn add_frame(&mut self, frame: data::Frame) -> u32 {
        self.frames.push(frame);
        self.frames.len() as u32 - 1
    }
}

//! Converts the scene, in f64 and scene units, to the arrays that the kernels read, in f32 and render space.
//!
//! Render space has the camera at the origin and is scaled by a power of two to an extent near 1, so that kernels see the
//! same numbers whatever the size and the position of the scene. If pixels are very narrow, it has the camera's axes
//! (`view`). Emission is also scaled by a power of two.

mod builder;
mod coverage;
mod cuts;
mod device_scene;
mod diagnostics;
mod features;
mod finder;
mod hierarchies;
mod lamps_in_view;
mod light_parts;
mod light_paths;
mod light_tree;
mod mattes;
mod media;
mod mesh_tables;
mod meshes;
mod motion;
mod motion_tables;
mod moving_objects;
mod neighbours;
mod octahedral;
mod pairs;
mod projection;
mod sampled_lights;
mod square_sky;
mod swept;
mod tangents;
mod view;

use std::collections::HashMap;
use std::sync::Arc;

use glam::DVec3;

use crate::aov::{Aov, SceneSpace};
use crate::bitmap::FORMATS;
use crate::data::MAX_PRIMITIVES;
use crate::delta_light::WorldLight;
use crate::error::{Error, Result};
use crate::material::{Emitted, LobeWidth, Model, Slot, Vertices};
use crate::options::{FeatureSet, Integrator, RenderOptions};
use crate::printable::and_more;
use crate::scene::{Background, Bitmap, Material, Object, Scene, Step, light_groups};
use crate::shape::mesh::{Mesh, MeshShape};
use crate::shape::{BoundingShape, KINDS, ObjectTransform, RenderSpace, Shape, binary_exponent, exp2, mesh};
use crate::threads::join;
use builder::Builder;
use diagnostics::Search;
use finder::{Finder, MovingLight, Primitive, WorldMedium, extent};
use lamps_in_view::lamps_in_view;
use mesh_tables::Table;
use motion::Placement;
use projection::{Film, Lens};
use view::View;

pub use crate::material::MATERIALS;
pub use crate::texture::TEXTURES;
pub use device_scene::DeviceScene;
pub use features::{
    BACKGROUNDS, BOUNDARIES, DECLARED, Declared, EVERY_FEATURE, FIELDS, Features, NotSampled, PRIMITIVES, Quantities,
};
pub use hierarchies::Hierarchies;
pub use neighbours::Neighbours;
pub use sampled_lights::MOST_LIGHTS;
pub use view::axes_of;

/// A walk packs six bits with the index of a node (shaders/scene/traverse). This number of nodes takes 4 GiB.
const MAX_NODES: usize = 1 << 26;

/// The most media. Each takes one of the loop iterations that an invocation is allowed (shaders/stage/bounce).
const MOST_MEDIA: usize = 1024;

/// Flattens a scene for an image of `size` pixels. It reads only the options that change tables: the integrator, the build of the
/// hierarchies, the features, the filter, and whether there are numbers of objects.
///
/// # Errors
/// `Error::Scene` if there are more primitives or nodes than codes can number, or more media than a ray can cross.
pub fn flatten(scene: &Scene, size: (u32, u32), options: &RenderOptions) -> Result<DeviceScene> {
    flatten_with(scene, size, options, None)
}

/// Flattens a scene with the hierarchies of an earlier flattening, if there was one.
///
/// # Errors
/// The errors of [`flatten`].
pub fn flatten_with(
    scene: &Scene,
    size: (u32, u32),
    options: &RenderOptions,
    mut hierarchies: Option<&mut Hierarchies>,
) -> Result<DeviceScene> {
    if let Some(hierarchies) = &mut hierarchies {
        hierarchies.retain(scene);
    }
    let meshes = mesh::shapes(&scene.meshes);
    let camera = scene.camera.at(scene.camera.shutter.0);
    let view = View::new(&camera, size, scene.image);
    let mut finder = Finder::new(scene, &meshes, view.eye, &scene.camera);
    let world = Placement::resting(view.to_space);
    finder.add_all(&scene.objects, &world);
    let models = models(scene, &finder);
    let (features, used) = required(scene, &finder, &models);
    check_counts(scene, &finder, options)?;

    let extent = extent(view.eye, view.lens_radius(), &finder);
    let reflection = brightest_reflection(&finder, view.eye, extent);
    let emissions = emissions(scene, &finder, &models, &used);
    let of_media = finder.media.iter().map(WorldMedium::brightest).fold(0.0, f64::max);
    let [brightest, of_paths] = brightest(scene, &emissions).map(|radiance| radiance.max(reflection).max(of_media));
    let search = Search::new(scene, &finder, &view, extent, brightest > 0.0, &emissions);
    let length_exponent = binary_exponent(extent);
    let space = RenderSpace { eye: view.eye, scale: exp2(-length_exponent) };
    let radiance_exponent = binary_exponent(if brightest > 0.0 { brightest } else { 1.0 });
    let radiance_scale = exp2(-radiance_exponent);

    let to_scene =
        SceneSpace { eye: camera.look_from, axes: view.to_space.rotation.transpose(), exponent: length_exponent };
    let mut flat =
        DeviceScene { features, radiance_exponent, brightest: of_paths, space: to_scene, ..DeviceScene::default() };
    flat.light_groups = if options.aov.has(Aov::Lights) { light_groups::names(scene) } else { Vec::new() };
    mattes::add(&mut flat, scene, &options.aov, &finder.primitives);
    flat.warnings.extend(without_light(scene, brightest));
    flat.warnings.extend(without_direction(scene, &view));
    flat.warnings.extend(hidden_emissions(scene, &emissions));
    (flat.settings, flat.placement) = (view.settings(&space), view.placement(&space));
    if options.aov.has(Aov::Motion) {
        flat.neighbours = Some(Arc::new(Neighbours::of(scene, size, to_scene)));
    }
    flat.lamps = lamps_in_view(scene, &view, options.filter, &finder, &emissions, radiance_scale);
    let mut builder = Builder {
        scene,
        layouts: vec![None; meshes.len()],
        tables: vec![vec![Table::FIRST]; meshes.len()],
        space,
        quality: options.build,
        walk: options.walk,
        around_media: finder.media.iter().filter_map(|medium| medium.boundary.mesh()).map(|mesh| mesh.number).collect(),
        hierarchies,
        materials: vec![0; scene.materials.len()],
        framed: framed(&models, &finder.needed),
        needed: &finder.needed,
        models,
        shows_emission: emissions.iter().map(Emitted::is_seen).collect(),
        images: HashMap::new(),
        mesh_frames: HashMap::new(),
        grids: Vec::new(),
        heat: None,
        motions: None,
        flat,
    };
    builder.find_tables(&finder.primitives);
    if options.aov.has(Aov::Uv0) {
        builder.add_frames_of_objects(&finder.primitives);
    }
    builder.add_background(radiance_scale, &view.to_space);
    builder.add_materials(&used, radiance_scale);
    if builder.flat.features.has_extensions() || options.features == FeatureSet::All {
        builder.add_extensions(&used, radiance_scale);
    }
    builder.add_directional_albedos(&used, options.features == FeatureSet::All);
    builder.add_motions(&finder, &view.to_space, options.features == FeatureSet::All);
    let sample_lights = options.integrator == Integrator::Mis;
    let not_sampled = if sample_lights { brightest_of_plain_sky(&scene.background) } else { builder.flat.brightest };
    builder.flat.not_sampled = radiance_scale * not_sampled.max(of_media);
    // The warnings are searched for while the hierarchies are built.
    let (warnings, laid_out) =
        join(|| diagnostics::warnings(&search), || builder.add_objects(&finder, sample_lights, radiance_scale));
    laid_out?;
    let mut flat = builder.flat;
    flat.add_groups_of_materials(scene);
    check_tables(scene, &flat)?;
    flat.warnings.extend(warnings);
    let traced = flat.light_paths(options).count() > 0;
    flat.warnings.extend(stopped_by_glass(scene, &finder, &flat.features, traced));
    flat.features.quantities.shadow_rays = flat.features.quantities.lights > 0;
    require_camera(&mut flat.features, scene, &view);
    if options.features == FeatureSet::All {
        flat.require_all(sample_lights);
    }
    Ok(flat)
}

/// The features that the objects, materials, media and the background require, and whether an object uses each material.
fn required(scene: &Scene, finder: &Finder<'_>, models: &[Model<'_>]) -> (Features, Vec<bool>) {
    let mut features = Features::default();
    // Of materials that are smooth panes: whether they have textures.
    let panes = scene.materials.iter().zip(models).map(|((_, material), model)| {
        let is_pane = material.kind().is_pane && material.widths(&scene.bitmaps).contains(&LobeWidth::Specular);
        is_pane.then(|| model.slots().any(|slot| slot.is_textured()))
    });
    let panes: Vec<Option<bool>> = panes.collect();
    let pane_of = |primitive: &Primitive<'_>| panes[primitive.material as usize];
    let has_alpha = |primitive: &Primitive<'_>| models[primitive.material as usize].has_alpha();
    let is_smooth = |shape: &Shape<'_>| shape.mesh().is_some_and(|shape| !shape.mesh.normals.is_empty());
    let mut require = |fact: String, those: &dyn Fn(&Primitive<'_>) -> bool| {
        if let Some(first) = finder.primitives.iter().find(|primitive| those(primitive)) {
            features.require(fact, || scene.location_of(first.object).to_string());
        }
    };
    for (number, (name, kind)) in PRIMITIVES.iter().zip(KINDS).enumerate() {
        let is_own = |primitive: &Primitive<'_>| primitive.shape.number() == number;
        require(format!("shape.{name}"), &is_own);
        require(format!("smooth_pane.{name}"), &|own| is_own(own) && pane_of(own).is_some());
        let of_body = |own: &Primitive<'_>| is_own(own) && kind.encloses() && has_alpha(own);
        require(format!("body_with_alpha.{name}"), &of_body);
    }
    require("smooth".to_string(), &|primitive| is_smooth(&primitive.shape));
    require("textured_pane".to_string(), &|primitive| pane_of(primitive) == Some(true));
    features.quantities.alpha_on_bodies = features.any("body_with_alpha").is_some();
    features.quantities.pane_textures = features.any("textured_pane").is_some();
    // Whether an object uses each material.
    let mut used = vec![false; scene.materials.len()];
    let needed = |primitive: &Primitive<'_>| &finder.needed[primitive.material as usize];
    for &number in finder.primitives.iter().flat_map(needed) {
        if !std::mem::replace(&mut used[number], true) {
            let (name, material) = &scene.materials[number];
            require_material(&mut features, scene, name, material, &models[number]);
        }
    }
    finder.media.iter().for_each(|medium| require_medium(&mut features, scene, medium));
    if let Background::Image { path, .. } = &scene.background
        && let Some(bitmap) = scene.bitmaps.colours(path)
    {
        let at = scene.location(&[Step::Field("background")]);
        features.require(texel_format(bitmap), || format!("background at {at}"));
    }
    (features, used)
}

/// # Errors
/// `Error::Scene` if there are more primitives, media or lights than can be numbered, or lights that only light sampling finds, without it.
fn check_counts(scene: &Scene, finder: &Finder<'_>, options: &RenderOptions) -> Result<()> {
    let faces: usize = scene.meshes.values().map(|mesh| mesh.triangles.len() + mesh.positions.len() * 2).sum();
    check_count(scene, "primitives", finder.primitives.len().max(faces), MAX_PRIMITIVES)?;
    if finder.media.len() > MOST_MEDIA {
        let message = format!("expected at most {MOST_MEDIA} media, found {}", finder.media.len());
        return Err(scene.error(&[], message));
    }
    if let Some(MovingLight { object, .. }) = finder.lights.first()
        && options.integrator == Integrator::Bsdf
    {
        return Err(needs_light_sampling(scene, object));
    }
    check_count(scene, "lights without size", finder.lights.len(), MOST_LIGHTS)
}

/// # Errors
/// `Error::Scene` if the tables of meshes or of hierarchies have more elements than codes can number.
fn check_tables(scene: &Scene, flat: &DeviceScene) -> Result<()> {
    check_count(scene, "faces, vertices and texture coordinates of meshes", flat.meshes.len(), MAX_PRIMITIVES)?;
    check_count(scene, "nodes in the hierarchies", flat.nodes.len(), MAX_NODES)
}

fn check_count(scene: &Scene, what: &str, found: usize, limit: usize) -> Result<()> {
    match found < limit {
        true => Ok(()),
        false => Err(scene.error(&[], format!("expected fewer than {limit} {what}, found {found}"))),
    }
}

fn require_camera(features: &mut Features, scene: &Scene, view: &View) {
    let of_camera =
        |field: &str| format!("camera.{field} at {}", scene.location(&[Step::Field("camera"), Step::Field(field)]));
    if scene.camera.aperture > 0.0 {
        features.require("lens", || of_camera("aperture"));
    }
    let projection = || of_camera(if scene.camera.projection.is_some() { "projection" } else { "vertical_fov" });
    if view.has_camera_axes {
        features.require("camera_axes", projection);
    }
    if let Some(fact) = view.film.fact() {
        features.require(fact, projection);
    }
    if let Film::Round { lens: Lens::Fisheye(model), .. } = view.film {
        features.quantities.fisheye = model as u32;
    }
}

/// The warning that nothing emits light.
fn without_light(scene: &Scene, brightest: f64) -> Option<String> {
    let at = scene.location(&[Step::Field("background")]);
    (brightest == 0.0).then(|| {
        format!(
            "{at}: background: nothing in this scene emits light, so that the image is black: give the background a colour, or an \
             object a DiffuseLight"
        )
    })
}

/// The warning that a part of the image is black, because its pixels have no direction.
fn without_direction(scene: &Scene, view: &View<'_>) -> Option<String> {
    let share = view.film.share_without_direction(view.size);
    let (pixels, percent) = (share * f64::from(view.size.0) * f64::from(view.size.1), 100.0 * share);
    let at = scene.location(&[Step::Field("camera"), Step::Field("projection")]);
    let name = scene.camera.projection().name();
    (share > 0.0).then(|| {
        format!("{at}: projection: {pixels:.0} pixels, {percent:.1} % of the image, have no direction with {name}, and are black")
    })
}

/// Records the features that a material on an object requires.
fn require_material(features: &mut Features, scene: &Scene, name: &str, material: &Material, model: &Model<'_>) {
    let at_material = || format!("\"{name}\" at {}", scene.material_location(name));
    let kind = MATERIALS[material.number_on_device()];
    let mut facts = vec!["material"];
    for width in material.widths(&scene.bitmaps) {
        // Light is sampled for narrow lobes, too.
        facts.extend(match width {
            LobeWidth::Wide => ["wide_lobe"].as_slice(),
            LobeWidth::Narrow => &["narrow_lobe", "wide_lobe"],
            LobeWidth::Specular => &["specular_lobe"],
        });
    }
    facts.extend((material.kind().is_transmissive && model.slot.is_some()).then_some("tinted"));
    facts.extend(model.absorption.is_some().then_some("absorbing"));
    facts.extend(model.rows.iter().map(|row| row.kind.name));
    facts.into_iter().for_each(|fact| features.require(format!("{fact}.{kind}"), at_material));
    for texture in model.slots().filter_map(|slot| slot.texture.shader_number()) {
        features.require(format!("texture.{}", TEXTURES[texture]), at_material);
    }
    if model.slots().any(|slot| slot.texture.is_number()) {
        features.require("number_images", at_material);
    }
    for bitmap in model.slots().filter_map(|slot| slot.texture.bitmap(&scene.bitmaps)) {
        features.require(texel_format(bitmap), at_material);
    }
}

fn texel_format(bitmap: &Bitmap) -> String {
    format!("texel.{}", FORMATS[bitmap.format.number()])
}

/// Records the features that a medium requires.
fn require_medium(features: &mut Features, scene: &Scene, medium: &WorldMedium<'_>) {
    let kind = medium.boundary.code_kind();
    let at_object = || scene.location_of(medium.object).to_string();
    if let Some((name, _)) = BOUNDARIES.iter().find(|(_, number)| *number == kind) {
        features.require(format!("boundary.{name}"), at_object);
    }
    // The width is that of width_of_phase (shaders/medium/phase_pdf).
    if LobeWidth::of_width((3f64.sqrt() * (1.0 - medium.anisotropy.abs())) as f32) == LobeWidth::Narrow {
        features.require("narrow_medium", at_object);
    }
    if let Some(texture) = medium.albedo.shader_number() {
        features.require(format!("texture.{}", TEXTURES[texture]), at_object);
        features.require("textured_medium", at_object);
    }
    if let Some(varying) = medium.varying {
        features.require(varying.fact(), at_object);
    }
    if let Some(emission) = medium.emission {
        features.require("medium_emission", at_object);
        if emission.grid().is_some() {
            features.require("blackbody", at_object);
        }
    }
}

/// The error that `--integrator bsdf` cannot find a light.
fn needs_light_sampling(scene: &Scene, object: &Object) -> Error {
    let name = object.name();
    let message = format!(
        "a {name} has no size, so that no path can hit it: --integrator bsdf finds no light of it. Use --integrator mis, or a small sphere \
         with a DiffuseLight in its place"
    );
    scene.error_of(object, &message)
}

/// The warning that mirrors or glass stop the light of lights without size, which BSDF sampling cannot find.
/// `traced`: whether light paths find some of it.
fn stopped_by_glass(scene: &Scene, finder: &Finder<'_>, features: &Features, traced: bool) -> Option<String> {
    let MovingLight { object, .. } = finder.lights.first()?;
    let specular = || {
        let reason = |name: &&str| features.reason(&format!("specular_lobe.{name}"));
        MATERIALS.iter().zip(Material::KINDS).filter_map(move |(name, kind)| Some((reason(name)?, kind)))
    };
    let solid = specular().find_map(|(reason, kind)| (!kind.is_pane).then_some(reason));
    let (shiny, how) = match solid {
        Some(solid) => (solid, "by a mirror or through glass"),
        None => (specular().next()?.0, "by the reflection of a pane"),
    };
    if !features.samples_light_anywhere() {
        return None;
    }
    let more = and_more(finder.lights.len() - 1);
    let (location, name) = (scene.location_of(object), object.name());
    Some(match traced {
        true => format!(
            "{location}: this {name} has no size. Light paths find it {how} ({shiny}), but not what a mirror or glass shows of that: that \
             light of it is missing in the image. A small sphere with a DiffuseLight brings it back, as noise{more}"
        ),
        false => format!(
            "{location}: this {name} has no size, so that no path finds it {how} ({shiny}): that light of it is missing in the image. \
             --light-paths auto finds most of it. A small sphere with a DiffuseLight brings it back, as noise{more}"
        ),
    })
}

/// The number of the brightest lights without size that count for the unit of radiance.
const MOST_DELTA_LIGHTS: usize = 64;
/// The smallest assumed distance of a light from a lit surface, as a share of the scene's extent.
const LEAST_LIGHT_DISTANCE: f64 = 1.0 / (1u64 << 14) as f64;

/// An estimate of the largest radiance of a white diffuse surface lit by a light without size: at the nearest bounding shape of an object.
fn brightest_reflection(finder: &Finder<'_>, eye: DVec3, extent: f64) -> f64 {
    let space = RenderSpace { eye, scale: 1.0 };
    let mut lights: Vec<_> = finder.lights.iter().map(|moving| &moving.light).collect();
    lights.sort_by(|a, b| b.colour.max_element().total_cmp(&a.colour.max_element()));
    let shapes = finder.bodies().filter(|_| !lights.is_empty());
    let shapes = shapes.map(|(shape, to_world, _)| shape.bounding_shape(&ObjectTransform { to_world, space }));
    let shapes: Vec<BoundingShape> = shapes.collect();
    let reflection = |light: &WorldLight| {
        let distance = light.position.map_or(1.0, |position| {
            let nearest = shapes.iter().map(|shape| shape.distance(position - eye)).fold(f64::INFINITY, f64::min);
            let nearest = if nearest.is_finite() { nearest } else { extent };
            nearest.max(LEAST_LIGHT_DISTANCE * extent)
        });
        light.brightest_reflection(distance)
    };
    lights.into_iter().take(MOST_DELTA_LIGHTS).map(reflection).fold(0.0, f64::max)
}

/// The properties of the materials on the objects that have them.
fn models<'a>(scene: &'a Scene, finder: &Finder<'_>) -> Vec<Model<'a>> {
    let mut vertices = vec![Vertices::default(); scene.materials.len()];
    for primitive in &finder.primitives {
        if let Some(MeshShape { mesh, .. }) = primitive.shape.mesh() {
            for &number in &finder.needed[primitive.material as usize] {
                vertices[number].colours |= !mesh.colours.is_empty();
                vertices[number].alphas |= !mesh.alphas.is_empty();
            }
        }
    }
    scene.materials.iter().zip(vertices).map(|((_, material), vertices)| material.model_on_device(vertices)).collect()
}

/// The slots of each material that have a frame on objects: its own, and those of its parts.
fn framed<'a>(models: &[Model<'a>], needed: &[Vec<usize>]) -> Vec<Vec<Slot<'a>>> {
    needed.iter().map(|numbers| numbers.iter().flat_map(|number| models[*number].framed()).collect()).collect()
}

/// The emission of each material that an object has; nothing of the others.
fn emissions(scene: &Scene, finder: &Finder<'_>, models: &[Model<'_>], used: &[bool]) -> Vec<Emitted> {
    let emitted = models.iter().enumerate().zip(used).map(|((number, model), used)| match used {
        true => model.most_emitted(&scene.bitmaps, || largest_of_vertices(finder, number)),
        false => Emitted::default(),
    });
    emitted.collect()
}

/// The warnings about emissions that no alpha shows.
fn hidden_emissions(scene: &Scene, emissions: &[Emitted]) -> Vec<String> {
    let hidden = scene.materials.iter().zip(emissions);
    let hidden = hidden.filter(|(_, emitted)| emitted.radiance > 0.0 && emitted.coverage == 0.0);
    let warning = |((name, material), _): (&(String, Material), _)| {
        let message = "this emission shows nowhere, because the alpha is 0 or below alpha_cutoff on all of the surface: raise the alpha, or \
                       remove the emission";
        let top = scene.top();
        let materials = top.field("materials");
        materials.key(name).variant(material.name()).field("emission").warning(message)
    };
    hidden.map(warning).collect()
}

/// The largest component of the radiance of a sky that is never sampled as a light: any but an image.
fn brightest_of_plain_sky(background: &Background) -> f64 {
    match background {
        Background::Solid(colour) => colour.max_element(),
        Background::Gradient { bottom, top } => bottom.max(*top).max_element(),
        Background::Image { .. } => 0.0,
    }
}

/// The largest component of the radiance of the background and of emissions: its root mean square over paths that meet it, and what a path
/// carries. A path meets a surface of coverage a with the probability a, so that the first is √a of the second.
fn brightest(scene: &Scene, emissions: &[Emitted]) -> [f64; 2] {
    let sky = match &scene.background {
        Background::Image { path, tint, .. } => {
            scene.bitmaps.colours(path).map_or(0.0, |bitmap| bitmap.brightest(*tint))
        }
        plain => brightest_of_plain_sky(plain),
    };
    let seen = emissions.iter().filter(|emitted| emitted.is_seen());
    seen.fold([sky; 2], |[mean, most], &Emitted { radiance, coverage }| {
        [mean.max(radiance * coverage.sqrt()), most.max(radiance)]
    })
}

/// The largest alpha and the largest colour that the vertices of a material's objects have; 1 for a shape without.
fn largest_of_vertices(finder: &Finder<'_>, material: usize) -> [f64; 2] {
    let own = finder.primitives.iter().filter(|primitive| primitive.material as usize == material);
    let meshes: HashMap<_, _> =
        own.map(|primitive| (primitive.shape.mesh().map(|shape| shape.number), primitive.shape.mesh())).collect();
    let largest =
        |codes: &mut dyn Iterator<Item = u16>| f64::from(codes.max().unwrap_or(u16::MAX)) / f64::from(u16::MAX);
    let of_mesh = |shape: &MeshShape<'_>| {
        let Mesh { alphas, colours, .. } = shape.mesh;
        [largest(&mut alphas.iter().copied()), largest(&mut colours.iter().flatten().copied())]
    };
    let all = meshes.into_values().map(|shape| shape.map_or([1.0; 2], of_mesh));
    all.fold([0.0; 2], |[a, b], [alpha, colour]| [alpha.max(a), colour.max(b)])
}

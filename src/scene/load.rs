//! Reads a scene file: text, then values, then checks, then images and meshes.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use glam::DVec3;

use super::animation_frame::AnimationFrame;
use super::assets::Assets;
use super::explain::hash_at_start;
use super::file::{LONGEST_SCENE, OnProgress, Reading};
use super::findings::Findings;
use super::gltf_options::{GltfOptions, Sky};
use super::gltf_path::is_gltf;
use super::imported::Imported;
use super::mitsuba::{self, is_mitsuba};
use super::model::Scene;
use super::pbrt::{self, is_pbrt};
use super::recover::{Parts, parts_of};
use super::sky::SKY;
use super::types::*;
use super::write::relative;
use super::{gltf, grids, image_files, mesh_files, validate};
use crate::error::{Error, Result};
use crate::printable::one_line;
use crate::shape::Aabb;
use crate::source::{MOST_VALUES, Source};

impl Scene {
    /// Reads and validates a scene file, and loads the images and meshes that it names.
    ///
    /// Every error is an [`Error::Scene`], or several of them. A file that cannot be read has no line.
    pub fn load(path: &Path) -> Result<Scene> {
        Scene::load_as(path, &GltfOptions::default(), &mut |_, _, _| {}, &mut Assets::default())
    }

    /// Reads and validates a scene, with the glTF options of the command line, and reports the progress of large files about every MiB.
    /// Images and meshes come from `assets` if the scene has been read before and their files have not changed.
    pub fn load_as(
        path: &Path,
        options: &GltfOptions,
        progress: &mut OnProgress,
        assets: &mut Assets,
    ) -> Result<Scene> {
        assets.begin(path);
        if is_gltf(path) || mesh_files::is_mesh(path) {
            return of_model(path, path, options, progress, assets);
        }
        if is_mitsuba(path) || is_pbrt(path) {
            return of_another(path, path, options, progress, assets);
        }
        if let Some(what) = other_kind(path) {
            return Err(of_file(path, what));
        }
        options.refuse(path, false)?;
        let file = File::open(path).map_err(|error| cannot_read(path, &error))?;
        parse(text_of(file, path)?, path, progress, assets).map(|scene| scene.in_frame(options.frame))
    }

    /// The scene of a glTF file or a mesh file, as the scene file `to` would have it. `assets` then has the files that it was read from.
    pub fn of_model(path: &Path, to: &Path, options: &GltfOptions, assets: &mut Assets) -> Result<Scene> {
        if is_mitsuba(path) || is_pbrt(path) {
            assets.begin(path);
            return of_another(path, to, options, &mut |_, _, _| {}, assets);
        }
        if !is_gltf(path) && !mesh_files::is_mesh(path) {
            let expected = "expected a file that ends in .glb, .gltf, .xml, .pbrt, .obj, .ply or .stl";
            return Err(Error::Usage(format!("{}: {expected}", path.display())));
        }
        assets.begin(path);
        of_model(path, to, options, &mut |_, _, _| {}, assets)
    }

    /// Reads a scene's text, such as that on standard input. `path` is its name in errors, as for [`Scene::parse`].
    pub fn read(reader: impl Read, path: &Path, progress: &mut OnProgress) -> Result<Scene> {
        parse(text_of(reader, path)?, path, progress, &mut Assets::default())
    }

    /// Parses a text in memory. `path` is its name in errors; relative paths start at the folder of `path`.
    pub fn parse(text: &str, path: &Path) -> Result<Scene> {
        parse(text.to_owned(), path, &mut |_, _, _| {}, &mut Assets::default())
    }
}

fn cannot_read(path: &Path, error: &io::Error) -> Error {
    of_file(path, format!("cannot read the scene file: {error}"))
}

/// An error about all of a file.
fn of_file(path: &Path, message: impl Into<String>) -> Error {
    Error::Scene {
        location: Source::without_text(path).location(0),
        field: "Scene".to_owned(),
        message: message.into(),
    }
}

/// What to do with a file of another kind than scenes, by the ending of its name.
fn other_kind(path: &Path) -> Option<String> {
    let file = path.display();
    match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
        "exr" => Some(format!(
            "expected a scene, found an image: `gpu-rt develop {file} -o FILE.png` makes a picture of it, `gpu-rt compare` measures its \
             error, and `gpu-rt render SCENE -o {file} --resume` goes on with its render"
        )),
        "png" | "jpg" | "jpeg" | "hdr" | "webp" => {
            Some("expected a scene, found an image: a scene names it as a texture, Image(path: \"..\")".to_owned())
        }
        "blend" => Some("expected a scene, found a file of Blender: export it as glTF 2.0 (.glb)".to_owned()),
        _ => None,
    }
}

/// The text of a scene file, whose name is `path`.
fn text_of(reader: impl Read, path: &Path) -> Result<String> {
    let mut bytes = Vec::new();
    reader.take(LONGEST_SCENE + 1).read_to_end(&mut bytes).map_err(|error| cannot_read(path, &error))?;
    if bytes.starts_with(b"glTF") {
        let message = "expected the text of a scene, found a glTF file: its name ends in .glb";
        return Err(Source::new(String::new(), path).error(&[], message));
    }
    String::from_utf8(bytes).map_err(|error| {
        let (good, rest) = error.as_bytes().split_at(error.utf8_error().valid_up_to());
        let bad = rest.first().copied().unwrap_or_default();
        let good = Source::new(String::from_utf8_lossy(good).into_owned(), path);
        let message = format!("expected UTF-8 text, found the byte 0x{bad:02x}");
        good.error_at(good.text().len(), &[], message)
    })
}

/// Makes the scene that a text describes, and checks it.
/// Images and meshes that `assets` has are not read again.
fn parse(mut text: String, path: &Path, progress: &mut OnProgress, assets: &mut Assets) -> Result<Scene> {
    if text.starts_with('\u{feff}') {
        text.drain(..'\u{feff}'.len_utf8());
    }
    if text.len() as u64 > LONGEST_SCENE {
        let message = format!("the scene file is longer than {LONGEST_SCENE} bytes");
        return Err(Source::new(String::new(), path).error(&[], message));
    }
    let source = Source::new(text, path);
    if let Some(at) = source.spans.one_too_many {
        let message = format!("expected at most {MOST_VALUES} values in a scene file: replace objects by meshes");
        return Err(source.error_at(at as usize, &[], message));
    }
    if let Some(error) = hash_at_start(&source) {
        return Err(error);
    }
    if source.spans.root.is_none() && source.spans.unclosed_comment.is_none() {
        let message = "the scene file is empty: expected Scene(image: .., camera: .., ..)";
        return Err(source.error(&[], message));
    }
    let mut findings = Findings::default();
    let parts = parts_of(&source, &mut findings)?;
    let mut scene = Scene::of_parts(parts, source);
    add_gltf(&mut scene, &mut findings, progress, assets);
    finish(&mut scene, findings, progress, assets)?;
    Ok(scene)
}

/// Reads the contents of the glTF files that objects name.
fn add_gltf(scene: &mut Scene, findings: &mut Findings, progress: &mut OnProgress, assets: &mut Assets) {
    let (mut paths, mut known) = (Vec::new(), HashMap::new());
    scene.visit_objects(&mut |at, object| {
        let Object::Gltf { path, watts, thin, frame, fps, .. } = object else { return };
        let frame = frame.map(|number| AnimationFrame { number, fps: *fps });
        // Other times are refused where numbers are checked.
        let seconds = frame.as_ref().map(AnimationFrame::seconds).filter(|seconds| seconds.is_finite());
        let reading = gltf::Reading { asker: &gltf::OBJECT, watts: *watts, thin: *thin, seconds };
        if let Some(before) = known.insert(path.clone(), reading) {
            let alike = "another Gltf(..) reads this file in another way: expected the same fields in both, or a copy of the file";
            findings.record(if before == reading { Ok(()) } else { Err(at.field("path").error(alike)) });
            return;
        }
        let file = scene.source.resolve(path);
        assets.stamp_files(&file);
        let read = match is_gltf(&file) {
            true => {
                let open = assets.gltf.open(&file, progress);
                open.and_then(|file| file.contents(path, &format!("{path}#"), &reading))
            }
            false => Err("expected a path that ends in .gltf or .glb".to_owned().into()),
        };
        let read = read.map_err(|gltf::GltfError { at: part, reason }| at.field("path").error_in(&file, &part, &reason));
        paths.extend(findings.record(read).map(|contents| (path.clone(), contents)));
    });
    for (path, contents) in paths {
        let file = scene.source.resolve(&path);
        scene.notes.extend(contents.notes.iter().map(|note| format!("{}: {note}", one_line(&file.to_string_lossy()))));
        scene.materials.extend(contents.materials);
        fill(&mut scene.objects, &path, &contents.objects);
    }
}

/// Gives the objects of a glTF file to those that name it.
fn fill(objects: &mut [Object], name: &str, contents: &[Object]) {
    for object in objects {
        match object {
            Object::Gltf { path, objects, .. } if path == name => *objects = contents.to_vec(),
            Object::Group(objects) => fill(objects, name, contents),
            Object::Transformed { object, .. } | Object::Moving { object, .. } | Object::Named { object, .. } => {
                fill(std::slice::from_mut(object), name, contents)
            }
            _ => {}
        }
    }
}

/// The scene of a glTF file or a mesh file, as the scene file `to` would have it: paths are relative to its folder.
fn of_model(
    path: &Path,
    to: &Path,
    options: &GltfOptions,
    progress: &mut OnProgress,
    assets: &mut Assets,
) -> Result<Scene> {
    options.refuse_mitsuba(path)?;
    let source = Source::without_text(path);
    let broken = |gltf::GltfError { at, reason }: gltf::GltfError| Error::Scene {
        location: source.location(0),
        field: if at.is_empty() { "glTF".to_owned() } else { at },
        message: reason,
    };
    assets.stamp_files(path);
    let seen = |file: &Path| match path == to {
        true => file.file_name().map_or(file.to_owned(), Into::into),
        false => relative(to.parent().unwrap_or(Path::new("")), file),
    };
    let note = |note: &str| format!("{}: {note}", source.location(0));
    let (mut contents, is_of_blender, libraries) = match is_gltf(path) {
        true => {
            let name = seen(path).to_string_lossy().into_owned();
            let seconds = options.frame.as_ref().map(AnimationFrame::seconds);
            let reading = gltf::Reading { asker: &gltf::OPTIONS, watts: options.watts, thin: options.thin, seconds };
            let file = assets.gltf.open(path, progress).map_err(broken)?;
            let mut contents = file.contents(&name, "", &reading).map_err(broken)?;
            contents.notes.iter_mut().for_each(|text| *text = note(text));
            (contents, file.blender().is_some(), Vec::new())
        }
        false => {
            options.refuse(path, true)?;
            // What is beside the file keeps its place there.
            let folder = path.parent().unwrap_or(Path::new(""));
            let seen = |file: &Path| match (path == to, file.strip_prefix(folder)) {
                (true, Ok(beside)) => beside.to_string_lossy().into_owned(),
                _ => seen(file).to_string_lossy().into_owned(),
            };
            let (contents, libraries) = mesh_files::contents(path, &seen, progress, assets)?;
            (contents, false, libraries)
        }
    };
    let has_lamps = contents.has_lights();
    let view = contents.choose(options.camera.as_deref()).map_err(Error::Usage)?;
    let has_view = view.is_some();
    let (camera, image) = view.unwrap_or_else(|| gltf::framing(Aabb::around([DVec3::ZERO])));
    let image_sky = |path: String| Background::Image {
        path,
        tint: Colour::ONE,
        by: Vec::new(),
        layout: SkyLayout::LatitudeLongitude,
    };
    let background = match &options.sky {
        Some(Sky::Image(sky)) if path == to => image_sky(sky.clone()),
        Some(Sky::Image(sky)) => image_sky(seen(Path::new(sky)).to_string_lossy().into_owned()),
        Some(Sky::Default) => SKY,
        Some(Sky::None) | None => Background::Solid(Colour::ZERO),
    };
    let parts = Parts {
        image: Some(image),
        camera: Some(camera),
        background: Some(background),
        materials: contents.materials,
        objects: Some(contents.objects),
        render: RenderDefaults::default(),
    };
    let scene = Scene::of_parts(parts, Source::without_text(to));
    let mut scene = Scene { frame: options.frame, notes: contents.notes, assets: contents.assets, libraries, ..scene };
    finish(&mut scene, Findings::default(), progress, assets)?;
    if is_of_blender && !has_lamps {
        scene.notes.push(note(
            "it has no lamps: Blender's exporter writes them if Punctual Lights is ticked under Include, but never area lamps and the world \
             (--sky FILE, --sun)",
        ));
    }
    if options.sky.is_none() {
        let of_sky = scene.add_sky(&contents.meshes);
        scene.notes.extend(of_sky.map(|text| note(&text)));
    }
    scene.objects.extend(options.sun.map(gltf::sun));
    if !has_view {
        let ticked =
            if is_of_blender { "; Blender's exporter writes them if Cameras is ticked under Include" } else { "" };
        scene.notes.push(note(&format!("it has no camera: one that sees all of it is used{ticked}")));
        (scene.camera, scene.image) = gltf::framing(gltf::bounds(&contents.meshes, &scene.meshes));
    }
    Ok(scene)
}

/// The scene of a file of another renderer, as the scene file `to` would have it.
fn of_another(
    path: &Path,
    to: &Path,
    options: &GltfOptions,
    progress: &mut OnProgress,
    assets: &mut Assets,
) -> Result<Scene> {
    let defines = if is_pbrt(path) { options.defines.clone() } else { Vec::new() };
    GltfOptions { defines, lossless: false, ..options.clone() }.refuse(path, false)?;
    let read = if is_pbrt(path) { pbrt::contents } else { mitsuba::contents };
    let Imported { parts, meshes, images, notes, files, places, findings, .. } =
        read(path, to, options, progress, assets)?;
    let made = meshes.keys().chain(images.paths()).cloned().collect();
    let scene = Scene::of_parts(parts, Source::with_places(to, places));
    let mut scene = Scene { meshes, bitmaps: images, made, notes, libraries: files, ..scene };
    finish(&mut scene, findings, progress, assets)?;
    Ok(scene.in_frame(options.frame))
}

/// Checks a scene, and reads its images and meshes.
fn finish(scene: &mut Scene, mut findings: Findings, progress: &mut OnProgress, assets: &mut Assets) -> Result<()> {
    validate::validate(scene, &mut findings);
    // Large files are not read for a scene that is refused, but all that are missing are named.
    let reading = if findings.is_empty() { Reading::Complete } else { Reading::IfThere };
    scene.bitmaps = image_files::load_all(scene, reading, &mut findings, assets);
    scene.meshes = mesh_files::load_all(scene, reading, &mut findings, progress, assets);
    scene.grids = grids::load_all(scene, reading, &mut findings, assets);
    assets.close();
    if findings.is_empty() && !scene.meshes.is_empty() {
        // Again, now that the meshes are known.
        validate::objects(scene, &mut findings);
    }
    findings.end()?;
    assets.end();
    Ok(())
}

impl Scene {
    /// The scene without its files. A section that is absent is replaced by something that is valid.
    fn of_parts(parts: Parts, source: Source) -> Scene {
        let camera = || Camera::pinhole(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 45.0);
        Scene {
            image: parts.image.unwrap_or(ImageSize { width: 1, height: 1 }),
            camera: parts.camera.unwrap_or_else(camera),
            background: parts.background.unwrap_or(Background::Solid(Colour::ZERO)),
            materials: parts.materials,
            objects: parts.objects.unwrap_or_default(),
            render: parts.render,
            bitmaps: Bitmaps::default(),
            meshes: BTreeMap::new(),
            grids: BTreeMap::new(),
            frame: None,
            neighbours: None,
            assets: Vec::new(),
            notes: Vec::new(),
            libraries: Vec::new(),
            made: HashSet::new(),
            source,
        }
    }
}

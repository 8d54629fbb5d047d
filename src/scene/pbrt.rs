//! pbrt-v4's files: what a file has becomes the camera, the materials and the objects of the scene file.
//!
//! `tokens` reads the words of a file, `params` the parameters of a directive; `reader` holds what has been made. Each other module makes one kind
//! of thing. What cannot be as pbrt has it is an error at its place, or a loss, which is told.

mod camera;
mod light;
mod material;
mod params;
mod reader;
mod shape;
mod tokens;

use std::io::Read;
use std::path::{Path, PathBuf};

use flate2::read::GzDecoder;
use glam::{DAffine3, DMat4, DVec3};

use super::assets::Assets;
use super::file::{self, LONGEST_SCENE, OnProgress};
use super::gltf_options::GltfOptions;
use super::gltf_path::has_ending;
use super::mitsuba::Contents;
use super::mitsuba::transform::look_at;
use super::recover::Parts;
use super::types::*;
use crate::error::{Error, Result};
use crate::printable::quote;
use params::Params;
use reader::{AS_THEY_ARE, Definition, Look, Medium, Reader, State};
use tokens::{Place, Token, Tokens};

/// How deep files include others, and how many there are.
const DEEPEST: usize = 100;
const MOST_FILES: usize = 1000;
/// The most states that are kept at a time.
const MOST_STATES: usize = 10_000;

/// Whether the ending of a path says pbrt.
pub fn is_pbrt(path: &Path) -> bool {
    has_ending(path, &["pbrt"]) || path.to_string_lossy().to_ascii_lowercase().ends_with(".pbrt.gz")
}

/// Reads a scene, as the scene file `to` would have it.
pub fn contents(
    path: &Path,
    to: &Path,
    options: &GltfOptions,
    progress: &mut OnProgress,
    assets: &mut Assets,
) -> Result<Contents> {
    if let Some((name, _)) = options.defines.first() {
        return Err(Error::Usage(format!("-D {name} is for scenes of Mitsuba, which are .xml: {}", path.display())));
    }
    let mut run = Run {
        reader: Reader::new(path, to, options.lossless, assets),
        states: Vec::new(),
        open: Vec::new(),
        camera: None,
    };
    run.file(path, progress)?;
    let Run { mut reader, states, .. } = run;
    if let Some((_, at)) = states.last() {
        reader.findings.refuse(at.error("AttributeBegin", "expected its end before that of the file"));
    }
    if !reader.in_world && reader.findings.is_empty() {
        let at = Place { file: path.into(), line: 1, column: 1 };
        reader.findings.refuse(at.error("scene", "expected WorldBegin"));
    }
    let Reader { camera, image, background, materials, objects, samples, max_depth, .. } = reader;
    let parts = Parts {
        image: Some(image),
        camera: camera.or_else(|| Some(Camera::pinhole(DVec3::ZERO, DVec3::Z, DVec3::Y, 90.0))),
        background,
        materials,
        objects: Some(objects),
        render: RenderDefaults { samples, max_depth },
    };
    let Reader { meshes, notes, files, places, findings, .. } = reader;
    Ok(Contents { parts, meshes, notes, files, places, findings })
}

/// The run through the directives.
struct Run<'a> {
    reader: Reader<'a>,
    states: Vec<(State, Place)>,
    open: Vec<PathBuf>,
    /// The camera, which needs the film.
    camera: Option<(String, Params, DAffine3)>,
}

impl Run<'_> {
    fn file(&mut self, path: &Path, progress: &mut OnProgress) -> Result<()> {
        let whole = |message: String| Place { file: path.into(), line: 0, column: 0 }.error("scene", message);
        self.reader.assets.stamp_files(path);
        let mut bytes = file::read(path, "scene file", LONGEST_SCENE).map_err(whole)?;
        if bytes.starts_with(&[0x1f, 0x8b]) {
            let mut text = Vec::new();
            let unpacked = GzDecoder::new(&bytes[..]).take(LONGEST_SCENE + 1).read_to_end(&mut text);
            if unpacked.is_err() || text.len() as u64 > LONGEST_SCENE {
                return Err(whole(format!("expected a gzip file of at most {LONGEST_SCENE} bytes")));
            }
            bytes = text;
        }
        let text = String::from_utf8(bytes).map_err(|_| whole("expected UTF-8 text".to_owned()))?;
        self.open.push(std::fs::canonicalize(path).unwrap_or(path.to_owned()));
        let mut tokens = Tokens::new(path, &text);
        while let Some(token) = tokens.next()? {
            let at = tokens.place();
            let Token::Word(word) = token else {
                return Err(at.error("scene", format!("expected a directive, found {}", token.words())));
            };
            let done = self.directive(word, &at, &mut tokens, progress);
            let is_notation = matches!(done, Ok(false));
            if is_notation || self.reader.findings.is_full() {
                break;
            }
            self.reader.findings.record(done);
        }
        self.open.pop();
        Ok(())
    }

    /// Runs a directive. The result says whether the file can be read on.
    fn directive(
        &mut self,
        word: &str,
        at: &Place,
        tokens: &mut Tokens<'_>,
        progress: &mut OnProgress,
    ) -> Result<bool> {
        let stop = |run: &mut Self, error| {
            run.reader.findings.refuse(error);
            Ok(false)
        };
        // Errors of the notation end the file; those of a directive, once all of it is read, do not.
        macro_rules! read {
            ($what:expr) => {
                match $what {
                    Ok(found) => found,
                    Err(error) => return stop(self, error),
                }
            };
        }
        let state = &mut self.reader.state;
        match word {
            "Identity" => state.ctm = DAffine3::IDENTITY,
            "Translate" => state.ctm *= DAffine3::from_translation(DVec3::from_array(read!(tokens.numbers(word)))),
            "Scale" => state.ctm *= DAffine3::from_scale(DVec3::from_array(read!(tokens.numbers(word)))),
            "Rotate" => {
                let [angle, x, y, z] = read!(tokens.numbers(word));
                let axis = DVec3::new(x, y, z).try_normalize();
                let axis = axis.ok_or_else(|| at.error(word, "expected an axis that is not 0"))?;
                state.ctm *= DAffine3::from_axis_angle(axis, angle.to_radians());
            }
            "LookAt" => {
                let [a, b, c, d, e, f, g, h, i] = read!(tokens.numbers(word));
                let found = look_at(DVec3::new(a, b, c), DVec3::new(d, e, f), DVec3::new(g, h, i));
                state.ctm *= found.map_err(|message| at.error(word, message))?.inverse();
            }
            "Transform" | "ConcatTransform" => {
                let numbers: [f64; 16] = read!(tokens.numbers(word));
                let matrix = DMat4::from_cols_array(&numbers);
                if numbers[3] != 0.0 || numbers[7] != 0.0 || numbers[11] != 0.0 || numbers[15] != 1.0 {
                    return Err(
                        at.error(word, "expected 0 0 0 1 as its last row, which are the numbers 4, 8, 12 and 16")
                    );
                }
                let given = DAffine3::from_mat4(matrix);
                state.ctm = if word == "Transform" { given } else { state.ctm * given };
            }
            "ReverseOrientation" => state.is_reversed = !state.is_reversed,
            "CoordinateSystem" => {
                let name = read!(tokens.text(word, "its name"));
                let ctm = state.ctm;
                self.reader.systems.insert(name.to_owned(), ctm);
            }
            "CoordSysTransform" => {
                let name = read!(tokens.text(word, "its name"));
                let known = self.reader.systems.get(name).copied();
                let missing = || at.error(word, format!("there is no coordinate system {}", quote(name)));
                self.reader.state.ctm = known.ok_or_else(missing)?;
            }
            "AttributeBegin" | "TransformBegin" | "ObjectBegin" => {
                let name = if word == "ObjectBegin" { Some(read!(tokens.text(word, "its name"))) } else { None };
                if self.states.len() >= MOST_STATES {
                    return Err(at.error(word, format!("expected at most {MOST_STATES} of them at a time")));
                }
                self.states.push((self.reader.state.clone(), at.clone()));
                if let Some(name) = name {
                    if self.reader.definition.is_some() {
                        return Err(at.error(word, "expected no object inside another"));
                    }
                    self.reader.definition = Some(Definition { name: name.to_owned(), objects: Vec::new() });
                }
            }
            "AttributeEnd" | "TransformEnd" | "ObjectEnd" => {
                let begin = word.replace("End", "Begin");
                let (before, _) =
                    self.states.pop().ok_or_else(|| at.error(word, format!("expected {begin} before it")))?;
                match word {
                    "TransformEnd" => self.reader.state.ctm = before.ctm,
                    _ => self.reader.state = before,
                }
                if word == "ObjectEnd" {
                    let made = self
                        .reader
                        .definition
                        .take()
                        .ok_or_else(|| at.error(word, "expected ObjectBegin before it"))?;
                    self.reader.definitions.insert(made.name, made.objects);
                }
            }
            "ObjectInstance" => {
                let name = read!(tokens.text(word, "its name"));
                self.reader.instance(name, at)?;
            }
            "NamedMaterial" => {
                let name = read!(tokens.text(word, "its name"));
                let missing = || at.error(word, format!("there is no material {} above", quote(name)));
                self.reader.state.look = *self.reader.named_looks.get(name).ok_or_else(missing)?;
            }
            "MediumInterface" => {
                let inside = read!(tokens.text(word, "the name of a medium"));
                let outside =
                    if let Some(Token::Text(_)) = read!(tokens.peek()) { read!(tokens.text(word, "")) } else { inside };
                self.reader.state.inside = inside.to_owned();
                if !outside.is_empty() && outside != inside {
                    self.reader.lose(at, word, "the medium outside is not used: media are where their shapes are");
                }
            }
            "Include" | "Import" => {
                let name = read!(tokens.text(word, "a file"));
                let path = self.reader.resolve(name, at);
                if self.open.contains(&std::fs::canonicalize(&path).unwrap_or(path.clone())) {
                    return Err(at.error(word, format!("{} includes itself: expected no circle", path.display())));
                }
                if self.open.len() > DEEPEST || self.reader.files.len() >= MOST_FILES {
                    return Err(at.error(word, format!("expected at most {MOST_FILES} files, {DEEPEST} in each other")));
                }
                self.reader.files.push(path.clone());
                self.file(&path, progress).map_err(|error| match error {
                    Error::Scene { location, message, .. } if location.line == 0 => at.error(word, message),
                    other => other,
                })?;
            }
            "WorldBegin" => {
                self.reader.in_world = true;
                if let Some((kind, params, ctm)) = self.camera.take() {
                    self.reader.state.ctm = ctm;
                    let made = camera::camera(&kind, &params, &mut self.reader);
                    self.reader.state.ctm = DAffine3::IDENTITY;
                    made?;
                }
                self.reader.state.ctm = DAffine3::IDENTITY;
                self.reader.systems.insert("world".to_owned(), DAffine3::IDENTITY);
            }
            "WorldEnd" => {}
            "ColorSpace" => {
                let name = read!(tokens.text(word, "its name"));
                if name != "srgb" {
                    return Err(at.error(word, format!("expected srgb, found {}", quote(name))));
                }
            }
            "Option" => _ = read!(Params::read(word.to_owned(), at.clone(), tokens)),
            "Attribute" => {
                let target = read!(tokens.text(word, "what the parameters are of"));
                let params = read!(Params::read(format!("{word} {target}"), at.clone(), tokens));
                let known =
                    ["shape", "light", "material", "medium", "texture"].into_iter().find(|known| *known == target);
                let expected = "expected shape, light, material, medium or texture";
                let known = known.ok_or_else(|| at.error(word, expected))?;
                self.reader.state.defaults.entry(known).or_default().extend(params.into_defaults());
            }
            "Texture" => {
                let name = read!(tokens.text(word, "its name"));
                let kind = read!(tokens.text(word, "float or spectrum"));
                let class = read!(tokens.text(word, "its kind"));
                let params = read!(Params::read(format!("{word} {class}"), at.clone(), tokens));
                let params = params.with_defaults(self.defaults("texture"));
                if !["float", "spectrum"].contains(&kind) {
                    return Err(params.error(format!("expected float or spectrum, found {}", quote(kind))));
                }
                let is_colour = kind == "spectrum";
                let found = material::texture(class, is_colour, &params, &mut self.reader)?;
                self.reader.textures.insert((is_colour, name.to_owned()), found);
            }
            _ => return self.with_params(word, at, tokens, progress),
        }
        Ok(true)
    }

    fn defaults(&self, target: &str) -> &[params::Param] {
        self.reader.state.defaults.get(target).map_or(&[], Vec::as_slice)
    }

    /// Runs a directive of a kind with parameters.
    fn with_params(
        &mut self,
        word: &str,
        at: &Place,
        tokens: &mut Tokens<'_>,
        progress: &mut OnProgress,
    ) -> Result<bool> {
        const KNOWN: &[&str] = &[
            "Camera",
            "Film",
            "Sampler",
            "Integrator",
            "PixelFilter",
            "Accelerator",
            "Material",
            "MakeNamedMaterial",
            "MakeNamedMedium",
            "Shape",
            "LightSource",
            "AreaLightSource",
        ];
        if !KNOWN.contains(&word) {
            self.reader.findings.refuse(at.error(word, "this directive is not read"));
            return Ok(false);
        }
        let read = tokens.text(word, "its kind in quotes").and_then(|kind| {
            let params = Params::read(format!("{word} {kind}"), at.clone(), tokens)?;
            Ok((kind, params))
        });
        let (kind, params) = match read {
            Ok(read) => read,
            Err(error) => {
                self.reader.findings.refuse(error);
                return Ok(false);
            }
        };
        let of_options = ["Camera", "Film", "Sampler", "Integrator", "PixelFilter", "Accelerator"].contains(&word);
        if of_options == self.reader.in_world {
            let place = if of_options { "before" } else { "behind" };
            return Err(params.error(format!("expected it {place} WorldBegin")));
        }
        let reader = &mut self.reader;
        match word {
            "Camera" => {
                reader.systems.insert("camera".to_owned(), reader.state.ctm.inverse());
                self.camera = Some((kind.to_owned(), params, reader.state.ctm));
            }
            "Film" => camera::film(kind, &params, reader)?,
            "Sampler" => camera::sampler(&params, reader)?,
            "Integrator" => camera::integrator(kind, &params, reader)?,
            "PixelFilter" if kind == "box" => {}
            "PixelFilter" => {
                reader.lose(at, &params.title, "this filter is not used: --filter chooses one");
            }
            "Accelerator" => {}
            "Material" => {
                let params = params.with_defaults(reader.state.defaults.get("material").map_or(&[], Vec::as_slice));
                let made = material::material(kind, &params, reader)?;
                reader.looks.push(Look {
                    material: made,
                    mapping: reader.mapping.take().unwrap_or(AS_THEY_ARE),
                    name: kind.to_owned(),
                    at: at.clone(),
                });
                reader.state.look = reader.looks.len() - 1;
            }
            "MakeNamedMaterial" => {
                let class = params.word("type")?.ok_or_else(|| params.error("expected its type"))?;
                let made = material::material(class, &params, reader)?;
                reader.looks.push(Look {
                    material: made,
                    mapping: reader.mapping.take().unwrap_or(AS_THEY_ARE),
                    name: kind.to_owned(),
                    at: at.clone(),
                });
                reader.named_looks.insert(kind.to_owned(), reader.looks.len() - 1);
            }
            "MakeNamedMedium" => {
                if params.word("type")?.unwrap_or("homogeneous") != "homogeneous" {
                    return Err(params.error_at("type", "expected homogeneous: other media are not read"));
                }
                let scale = params.number_or("scale", 1.0)?;
                // Without them, pbrt's medium is that of its measurements of skin.
                let (Some(absorbed), Some(scattered)) = (params.colour("sigma_a")?, params.colour("sigma_s")?) else {
                    return Err(params.error("expected sigma_a and sigma_s"));
                };
                let extinction = scale * (absorbed + scattered);
                let share = |scattered: f64, all: f64| if all > 0.0 { scale * scattered / all } else { 0.0 };
                let albedo = Colour::new(
                    share(scattered.x, extinction.x),
                    share(scattered.y, extinction.y),
                    share(scattered.z, extinction.z),
                );
                let medium = Medium { extinction, albedo, anisotropy: params.number_or("g", 0.0)?, at: at.clone() };
                reader.end(&params);
                reader.media.insert(kind.to_owned(), medium);
            }
            "LightSource" => {
                let params = params.with_defaults(reader.state.defaults.get("light").map_or(&[], Vec::as_slice));
                light::light(kind, &params, reader)?;
            }
            "AreaLightSource" => {
                if kind != "diffuse" {
                    return Err(params.error("this area light is not read: expected diffuse"));
                }
                let params = params.with_defaults(reader.state.defaults.get("light").map_or(&[], Vec::as_slice));
                let area = light::area(params, reader)?;
                reader.areas.push(area);
                reader.state.area = Some(reader.areas.len() - 1);
            }
            _ => {
                let params = params.with_defaults(reader.state.defaults.get("shape").map_or(&[], Vec::as_slice));
                shape::shape(kind, &params, progress, reader)?;
            }
        }
        Ok(true)
    }
}

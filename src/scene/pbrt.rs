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
mod texture;
mod tokens;

use std::io::Read;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use flate2::read::GzDecoder;
use glam::{DAffine3, DMat4, DVec3};

use super::assets::Assets;
use super::file::{self, LONGEST_SCENE, OnProgress};
use super::gltf_options::GltfOptions;
use super::gltf_path::has_ending;
use super::imported::transform::look_at;
use super::imported::{Imported, Place, bodies};
use crate::error::{Error, Result};
use crate::printable::quote;
use params::Params;
use reader::{Definition, Look, Reader, State};
use tokens::{Failure, Token, Tokens};

/// The most files that are open at a time, and that a scene includes.
const DEEPEST: usize = 100;
const MOST_FILES: usize = 1000;
/// The most states that are kept at a time.
const MOST_STATES: usize = 10_000;

/// Whether the ending of a path says pbrt.
pub fn is_pbrt(path: &Path) -> bool {
    has_ending(path, &["pbrt"]) || path.to_string_lossy().to_ascii_lowercase().ends_with(".pbrt.gz")
}

/// Reads a scene, as the scene file `to` would have it.
pub fn contents<'a>(
    path: &Path,
    to: &Path,
    options: &GltfOptions,
    progress: &mut OnProgress,
    assets: &'a mut Assets,
) -> Result<Imported<'a>> {
    let made = Imported::new(path, to, options, assets);
    let mut run = Run {
        reader: Reader::new(path, made, progress),
        states: Vec::new(),
        open: Vec::new(),
        included: 0,
        camera: None,
    };
    run.file(path)?;
    let Run { reader: Reader { mut made, in_world, bodies, camera, .. }, states, .. } = run;
    bodies::tell(&bodies, camera, "pbrt", &mut made);
    if let Some((_, at)) = states.last() {
        made.findings.refuse(at.error("AttributeBegin", "expected its end before that of the file"));
    }
    if !in_world && made.findings.is_empty() {
        let at = Place { file: path.into(), line: 1, column: 1 };
        made.findings.refuse(at.error("scene", "expected WorldBegin"));
    }
    Ok(made)
}

/// The run through the directives.
struct Run<'a, 'p> {
    reader: Reader<'a, 'p>,
    states: Vec<(State, Place)>,
    open: Vec<PathBuf>,
    /// How many files were included.
    included: usize,
    /// The camera, which needs the film.
    camera: Option<(String, Params, DAffine3)>,
}

impl Run<'_, '_> {
    fn file(&mut self, path: &Path) -> Result<()> {
        let whole = |message: String| Place { file: path.into(), line: 0, column: 0 }.error("scene", message);
        self.reader.made.assets.stamp_files(path);
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
        while !self.reader.made.findings.is_full() {
            match self.next(&mut tokens) {
                Ok(true) => {}
                Ok(false) => break,
                Err(Failure::OfDirective(error)) => self.reader.made.findings.refuse(error),
                Err(Failure::OfNotation(error)) => {
                    self.reader.made.findings.refuse(error);
                    break;
                }
            }
        }
        self.open.pop();
        Ok(())
    }

    /// Runs the next directive. The result says whether there was one.
    fn next(&mut self, tokens: &mut Tokens<'_>) -> tokens::Result<bool> {
        let Some(token) = tokens.next()? else { return Ok(false) };
        let at = tokens.place();
        let Token::Word(word) = token else {
            return Err(Failure::at(&at, "scene", format!("expected a directive, found {}", token.words())));
        };
        match word {
            "Identity" | "Translate" | "Scale" | "Rotate" | "LookAt" | "Transform" | "ConcatTransform" => {
                self.transform(word, &at, tokens)?;
            }
            "AttributeBegin" | "TransformBegin" | "ObjectBegin" => self.begin(word, &at, tokens)?,
            "AttributeEnd" | "TransformEnd" | "ObjectEnd" => self.end(word, &at)?,
            "ObjectInstance" => shape::instance(tokens.text(word, "its name")?, &at, &mut self.reader)?,
            "Include" | "Import" => self.include(word, &at, tokens)?,
            "WorldBegin" => self.begin_world()?,
            "Attribute" => self.attribute(word, &at, tokens)?,
            "Texture" => self.texture(word, &at, tokens)?,
            "Camera" | "Film" | "Sampler" | "Integrator" | "PixelFilter" | "Accelerator" => {
                let (kind, params) = self.kind_of(word, &at, tokens)?;
                self.option(word, kind, params)?;
            }
            "Material" | "MakeNamedMaterial" | "MakeNamedMedium" | "Shape" | "LightSource" | "AreaLightSource" => {
                let (kind, params) = self.kind_of(word, &at, tokens)?;
                self.part(word, kind, params)?;
            }
            _ => self.other(word, &at, tokens)?,
        }
        Ok(true)
    }

    /// The kind of a directive, and its parameters.
    fn kind_of<'t>(&mut self, word: &str, at: &Place, tokens: &mut Tokens<'t>) -> tokens::Result<(&'t str, Params)> {
        let kind = tokens.text(word, "its kind in quotes")?;
        let params = Params::read(format!("{word} {kind}"), at.clone(), tokens)?;
        let reader = &mut self.reader;
        let params = params.with_files(|name, at| {
            let path = reader.resolve(name, at);
            reader.made.assets.stamp_files(&path);
            reader.made.add_file(&path);
            path
        })?;
        Ok((kind, params))
    }

    fn transform(&mut self, word: &str, at: &Place, tokens: &mut Tokens<'_>) -> tokens::Result<()> {
        let mut of_end = self.reader.state.ctm;
        let is_at_end = self.reader.state.is_at_end;
        let ctm = if is_at_end { &mut of_end } else { &mut self.reader.state.ctm };
        match word {
            "Identity" => *ctm = DAffine3::IDENTITY,
            "Translate" => *ctm *= DAffine3::from_translation(DVec3::from_array(tokens.numbers(word)?)),
            "Scale" => *ctm *= DAffine3::from_scale(DVec3::from_array(tokens.numbers(word)?)),
            "Rotate" => {
                let [angle, x, y, z] = tokens.numbers(word)?;
                let axis = DVec3::new(x, y, z).try_normalize();
                let axis = axis.ok_or_else(|| at.error(word, "expected an axis that is not 0"))?;
                *ctm *= DAffine3::from_axis_angle(axis, angle.to_radians());
            }
            "LookAt" => {
                let [a, b, c, d, e, f, g, h, i] = tokens.numbers(word)?;
                let found = look_at(DVec3::new(a, b, c), DVec3::new(d, e, f), DVec3::new(g, h, i));
                *ctm *= found.map_err(|message| at.error(word, message))?.inverse();
            }
            _ => {
                let numbers: [f64; 16] = tokens.numbers(word)?;
                if [numbers[3], numbers[7], numbers[11], numbers[15]] != [0.0, 0.0, 0.0, 1.0] {
                    let message = "expected 0 0 0 1 as its last row, which are the numbers 4, 8, 12 and 16";
                    return Err(at.error(word, message).into());
                }
                let given = DAffine3::from_mat4(DMat4::from_cols_array(&numbers));
                *ctm = if word == "Transform" { given } else { *ctm * given };
            }
        }
        Ok(())
    }

    fn begin(&mut self, word: &str, at: &Place, tokens: &mut Tokens<'_>) -> tokens::Result<()> {
        let name = if word == "ObjectBegin" { Some(tokens.text(word, "its name")?) } else { None };
        if self.states.len() >= MOST_STATES {
            return Err(at.error(word, format!("expected at most {MOST_STATES} of them at a time")).into());
        }
        self.states.push((self.reader.state.clone(), at.clone()));
        if let Some(name) = name {
            if self.reader.definition.is_some() {
                return Err(at.error(word, "expected no object inside another").into());
            }
            self.reader.definition = Some(Definition { name: name.to_owned(), ..Definition::default() });
        }
        Ok(())
    }

    fn end(&mut self, word: &str, at: &Place) -> tokens::Result<()> {
        let missing = || at.error(word, format!("expected {} before it", word.replace("End", "Begin")));
        let (before, _) = self.states.pop().ok_or_else(missing)?;
        match word {
            "TransformEnd" => self.reader.state.ctm = before.ctm,
            _ => self.reader.state = before,
        }
        if word == "ObjectEnd" {
            let made = self.reader.definition.take().ok_or_else(missing)?;
            self.reader.definitions.insert(made.name.clone(), Rc::new(made));
        }
        Ok(())
    }

    fn include(&mut self, word: &str, at: &Place, tokens: &mut Tokens<'_>) -> tokens::Result<()> {
        let name = tokens.text(word, "a file")?;
        let path = self.reader.resolve(name, at);
        if self.open.contains(&std::fs::canonicalize(&path).unwrap_or(path.clone())) {
            let message = format!("{} includes itself: expected no circle", path.display());
            return Err(at.error(word, message).into());
        }
        if self.open.len() > DEEPEST || self.included >= MOST_FILES {
            let message = format!("expected at most {MOST_FILES} files, {DEEPEST} in each other");
            return Err(at.error(word, message).into());
        }
        self.included += 1;
        self.reader.made.add_file(&path);
        let read = self.file(&path).map_err(|error| match error {
            Error::Scene { location, message, .. } if location.line == 0 => at.error(word, message),
            other => other,
        });
        Ok(read?)
    }

    fn begin_world(&mut self) -> tokens::Result<()> {
        self.reader.in_world = true;
        let camera = self.camera.take();
        let made = camera.map_or(Ok(()), |(kind, params, ctm)| {
            self.reader.state.ctm = ctm;
            camera::camera(&kind, &params, &mut self.reader)
        });
        self.reader.state.ctm = DAffine3::IDENTITY;
        self.reader.systems.insert("world".to_owned(), DAffine3::IDENTITY);
        Ok(made?)
    }

    fn attribute(&mut self, word: &str, at: &Place, tokens: &mut Tokens<'_>) -> tokens::Result<()> {
        let target = tokens.text(word, "what the parameters are of")?;
        let params = Params::read(format!("{word} {target}"), at.clone(), tokens)?;
        let known = ["shape", "light", "material", "texture"].into_iter().find(|known| *known == target);
        let known = known.ok_or_else(|| at.error(word, "expected shape, light, material or texture"))?;
        self.reader.state.defaults.entry(known).or_default().extend(params.into_defaults());
        Ok(())
    }

    fn texture(&mut self, word: &str, at: &Place, tokens: &mut Tokens<'_>) -> tokens::Result<()> {
        let (name, kind) = (tokens.text(word, "its name")?, tokens.text(word, "float or spectrum")?);
        let (class, params) = self.kind_of(word, at, tokens)?;
        let params = params.with_defaults(self.defaults("texture"));
        if !["float", "spectrum"].contains(&kind) {
            return Err(params.error(format!("expected float or spectrum, found {}", quote(kind))).into());
        }
        let is_colour = kind == "spectrum";
        let found = texture::texture(class, is_colour, &params, &mut self.reader)?;
        self.reader.textures.insert((is_colour, name.to_owned()), found);
        Ok(())
    }

    fn defaults(&self, target: &str) -> &[params::Param] {
        self.reader.state.defaults.get(target).map_or(&[], Vec::as_slice)
    }

    /// Runs a directive that stands before the world.
    fn option(&mut self, word: &str, kind: &str, params: Params) -> tokens::Result<()> {
        let reader = &mut self.reader;
        if reader.in_world {
            return Err(params.error("expected it before WorldBegin").into());
        }
        match word {
            "Camera" => {
                reader.systems.insert("camera".to_owned(), reader.state.ctm.inverse());
                self.camera = Some((kind.to_owned(), params, reader.state.ctm));
            }
            "Film" => camera::film(kind, &params, reader)?,
            "Sampler" => camera::sampler(&params, reader)?,
            "Integrator" => camera::integrator(kind, &params, reader)?,
            "PixelFilter" if kind != "box" => {
                reader.lose(&params, "", "this filter is not used: --filter chooses one");
            }
            _ => {}
        }
        Ok(())
    }

    /// Runs a directive that makes a part of the world.
    fn part(&mut self, word: &str, kind: &str, params: Params) -> tokens::Result<()> {
        if !self.reader.in_world {
            return Err(params.error("expected it after WorldBegin").into());
        }
        let target = match word {
            "Material" => "material",
            "LightSource" | "AreaLightSource" => "light",
            "Shape" => "shape",
            _ => "",
        };
        let params = params.with_defaults(self.defaults(target));
        let reader = &mut self.reader;
        match word {
            "Material" => reader.state.look = look(kind, kind, &params, reader)?,
            "MakeNamedMaterial" => {
                let class = params.word("type")?.ok_or_else(|| params.error("expected its type"))?;
                let made = look(class, kind, &params, reader)?;
                reader.named_looks.insert(kind.to_owned(), made);
            }
            "MakeNamedMedium" => {
                let made = light::medium(&params, reader)?;
                reader.media.insert(kind.to_owned(), (made, params.at));
            }
            "LightSource" => light::light(kind, &params, reader)?,
            "AreaLightSource" => {
                let area = light::area(kind, params, reader)?;
                reader.areas.push(area);
                reader.state.area = Some(reader.areas.len() - 1);
            }
            _ => shape::shape(kind, &params, reader)?,
        }
        Ok(())
    }

    fn other(&mut self, word: &str, at: &Place, tokens: &mut Tokens<'_>) -> tokens::Result<()> {
        let reader = &mut self.reader;
        match word {
            "ReverseOrientation" => reader.state.is_reversed = !reader.state.is_reversed,
            "CoordinateSystem" => {
                let name = tokens.text(word, "its name")?;
                reader.systems.insert(name.to_owned(), reader.state.ctm);
            }
            "CoordSysTransform" => {
                let name = tokens.text(word, "its name")?;
                let missing = || at.error(word, format!("there is no coordinate system {}", quote(name)));
                reader.state.ctm = *reader.systems.get(name).ok_or_else(missing)?;
            }
            "NamedMaterial" => {
                let name = tokens.text(word, "its name")?;
                let missing = || at.error(word, format!("there is no material {} above", quote(name)));
                reader.state.look = *reader.named_looks.get(name).ok_or_else(missing)?;
            }
            "MediumInterface" => {
                let inside = tokens.text(word, "the name of a medium")?;
                let has_outside = matches!(tokens.peek()?, Some(Token::Text(_)));
                let outside = if has_outside { tokens.text(word, "a name")? } else { inside };
                (reader.state.inside, reader.state.has_outside) = (inside.to_owned(), !outside.is_empty());
                if !outside.is_empty() && outside != inside {
                    reader.made.lose(at, word, "the medium outside is not used: media are where their shapes are");
                }
            }
            "ColorSpace" => {
                let name = tokens.text(word, "its name")?;
                if name != "srgb" {
                    return Err(at.error(word, format!("expected srgb, found {}", quote(name))).into());
                }
            }
            "Option" => _ = Params::read(word.to_owned(), at.clone(), tokens)?,
            "WorldEnd" => {}
            "TransformTimes" => _ = tokens.numbers::<2>(word)?,
            "ActiveTransform" => {
                let Some(Token::Word(which @ ("StartTime" | "EndTime" | "All"))) = tokens.next()? else {
                    return Err(Failure::at(at, word, "expected StartTime, EndTime or All"));
                };
                reader.state.is_at_end = which == "EndTime";
                reader.made.lose(at, word, "what moves is at rest, where it is when the shutter opens");
            }
            _ => return Err(Failure::at(at, word, "this directive is not read")),
        }
        Ok(())
    }
}

/// The index of a new material.
fn look(class: &str, name: &str, params: &Params, reader: &mut Reader) -> Result<usize> {
    let material = material::material(class, params, reader)?;
    let mapping = reader.mapping.take();
    reader.looks.push(Look { material, mapping, name: name.to_owned(), at: params.at.clone() });
    Ok(reader.looks.len() - 1)
}

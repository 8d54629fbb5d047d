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

use std::path::Path;
use std::rc::Rc;

use glam::{DAffine3, DMat4, DVec3};

use super::assets::Assets;
use super::file::OnProgress;
use super::gltf_options::GltfOptions;
use super::gltf_path::has_ending;
use super::imported::transform::look_at;
use super::imported::{Imported, Place, bodies, files};
use crate::error::{Result, require};
use crate::printable::quote;
use params::Params;
use reader::{Definition, Look, Reader};
use tokens::{Token, Tokens};

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
    let mut reader = Reader::new(path, made, progress);
    reader.file(path)?;
    let Reader { mut made, in_world, states, .. } = reader;
    bodies::tell("pbrt", &mut made);
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
impl Reader<'_, '_> {
    fn file(&mut self, path: &Path) -> Result<()> {
        let text = files::text(path, self.made.assets)?;
        let mut tokens = Tokens::new(path, &text);
        while !self.made.findings.is_full() && !tokens.is_broken {
            match self.next(&mut tokens) {
                Ok(true) => {}
                Ok(false) => break,
                Err(error) => self.made.findings.refuse(error),
            }
        }
        Ok(())
    }

    /// Runs the next directive. The result says whether there was one.
    fn next(&mut self, tokens: &mut Tokens<'_>) -> Result<bool> {
        let Some(token) = tokens.next()? else { return Ok(false) };
        let at = tokens.place();
        let Token::Word(word) = token else {
            return Err(tokens.broken("scene", format!("expected a directive, found {}", token.words())));
        };
        match word {
            "Identity" | "Translate" | "Scale" | "Rotate" | "LookAt" | "Transform" | "ConcatTransform" => {
                self.transform(word, &at, tokens)?;
            }
            "AttributeBegin" | "TransformBegin" | "ObjectBegin" => self.begin_state(word, &at, tokens)?,
            "AttributeEnd" | "TransformEnd" | "ObjectEnd" => self.end_state(word, &at)?,
            "ObjectInstance" => shape::instance(tokens.text(word, "its name")?, &at, self)?,
            "Include" | "Import" => self.include(word, &at, tokens)?,
            "WorldBegin" => self.begin_world()?,
            "Attribute" => self.attribute(word, &at, tokens)?,
            "Texture" => self.texture(word, &at, tokens)?,
            "Camera" | "Film" | "Sampler" | "Integrator" | "PixelFilter" | "Accelerator" | "Material"
            | "MakeNamedMaterial" | "MakeNamedMedium" | "Shape" | "LightSource" | "AreaLightSource" => {
                let (kind, params) = self.kind_of(word, &at, tokens)?;
                self.part(word, kind, params)?;
            }
            _ => self.other(word, &at, tokens)?,
        }
        Ok(true)
    }

    /// The kind of a directive, and its parameters.
    fn kind_of<'t>(&mut self, word: &str, at: &Place, tokens: &mut Tokens<'t>) -> Result<(&'t str, Params)> {
        let kind = tokens.text(word, "its kind in quotes")?;
        let params = Params::read(format!("{word} {kind}"), at.clone(), tokens)?;
        let params = params.with_files(|name, at| {
            let path = self.resolve(name, at);
            self.made.assets.stamp_files(&path);
            self.made.add_file(&path);
            path
        })?;
        Ok((kind, params))
    }

    fn transform(&mut self, word: &str, at: &Place, tokens: &mut Tokens<'_>) -> Result<()> {
        let mut of_end = self.state.ctm;
        let is_at_end = self.state.is_at_end;
        let ctm = if is_at_end { &mut of_end } else { &mut self.state.ctm };
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
                    return Err(at.error(word, message));
                }
                let given = DAffine3::from_mat4(DMat4::from_cols_array(&numbers));
                *ctm = if word == "Transform" { given } else { *ctm * given };
            }
        }
        Ok(())
    }

    fn begin_state(&mut self, word: &str, at: &Place, tokens: &mut Tokens<'_>) -> Result<()> {
        let name = if word == "ObjectBegin" { Some(tokens.text(word, "its name")?) } else { None };
        let wrong = || at.error(word, format!("expected at most {MOST_STATES} of them at a time"));
        require(self.states.len() < MOST_STATES, wrong)?;
        self.states.push((self.state.clone(), at.clone()));
        if let Some(name) = name {
            require(self.definition.is_none(), || at.error(word, "expected no object inside another"))?;
            self.definition = Some(Definition { name: name.to_owned(), ..Definition::default() });
        }
        Ok(())
    }

    fn end_state(&mut self, word: &str, at: &Place) -> Result<()> {
        let missing = || at.error(word, format!("expected {} before it", word.replace("End", "Begin")));
        let (before, _) = self.states.pop().ok_or_else(missing)?;
        match word {
            "TransformEnd" => self.state.ctm = before.ctm,
            _ => self.state = before,
        }
        if word == "ObjectEnd" {
            let made = self.definition.take().ok_or_else(missing)?;
            self.definitions.insert(made.name.clone(), Rc::new(made));
        }
        Ok(())
    }

    fn include(&mut self, word: &str, at: &Place, tokens: &mut Tokens<'_>) -> Result<()> {
        let name = tokens.text(word, "a file")?;
        let path = self.resolve(name, at);
        self.includes.open(&path).map_err(|message| at.error(word, message))?;
        self.made.add_file(&path);
        let read = self.file(&path);
        self.includes.close();
        read.map_err(|error| files::where_included(error, |message| at.error(word, message)))
    }

    fn begin_world(&mut self) -> Result<()> {
        self.in_world = true;
        self.state.ctm = DAffine3::IDENTITY;
        self.systems.insert("world".to_owned(), DAffine3::IDENTITY);
        match self.camera.take() {
            Some((kind, params, ctm)) => camera::camera(&kind, &params, &ctm.inverse(), self),
            None => Ok(()),
        }
    }

    fn attribute(&mut self, word: &str, at: &Place, tokens: &mut Tokens<'_>) -> Result<()> {
        let target = tokens.text(word, "what the parameters are of")?;
        let params = Params::read(format!("{word} {target}"), at.clone(), tokens)?;
        let known = ["shape", "light", "material", "texture"].into_iter().find(|known| *known == target);
        let known = known.ok_or_else(|| at.error(word, "expected shape, light, material or texture"))?;
        self.state.defaults.entry(known).or_default().extend(params.all);
        Ok(())
    }

    fn texture(&mut self, word: &str, at: &Place, tokens: &mut Tokens<'_>) -> Result<()> {
        let (name, kind) = (tokens.text(word, "its name")?, tokens.text(word, "float or spectrum")?);
        let (class, params) = self.kind_of(word, at, tokens)?;
        let params = params.with_defaults(self.state.defaults.get("texture"));
        let wrong = || params.error(format!("expected float or spectrum, found {}", quote(kind)));
        require(["float", "spectrum"].contains(&kind), wrong)?;
        let is_colour = kind == "spectrum";
        let found = texture::texture(class, is_colour, &params, self)?;
        self.textures.insert((is_colour, name.to_owned()), found);
        Ok(())
    }

    /// Runs a directive that has a kind and parameters.
    fn part(&mut self, word: &str, kind: &str, params: Params) -> Result<()> {
        let (is_option, target) = match word {
            "Material" => (false, "material"),
            "LightSource" | "AreaLightSource" => (false, "light"),
            "Shape" => (false, "shape"),
            "MakeNamedMaterial" | "MakeNamedMedium" => (false, ""),
            _ => (true, ""),
        };
        // The camera may stand in a medium, so that these have names on both sides.
        if word != "MakeNamedMedium" && is_option == self.in_world {
            let side = if is_option { "before" } else { "after" };
            return Err(params.error(format!("expected it {side} WorldBegin")));
        }
        let params = params.with_defaults(self.state.defaults.get(target));
        match word {
            "Camera" => {
                self.systems.insert("camera".to_owned(), self.state.ctm.inverse());
                self.camera = Some((kind.to_owned(), params, self.state.ctm));
            }
            "Film" => camera::film(kind, &params, self)?,
            "Sampler" => camera::sampler(&params, self)?,
            "Integrator" => camera::integrator(kind, &params, self)?,
            "PixelFilter" if kind != "box" => {
                self.lose(&params, "", "this filter is not used: --filter chooses one");
            }
            "Material" => self.state.look = self.look(kind, kind, &params)?,
            "MakeNamedMaterial" => {
                let class = params.word("type")?.ok_or_else(|| params.error("expected its type"))?;
                let look = self.look(class, kind, &params)?;
                self.named_looks.insert(kind.to_owned(), look);
            }
            "MakeNamedMedium" => {
                let made = light::medium(&params, self)?;
                self.media.insert(kind.to_owned(), (made, params.at));
            }
            "LightSource" => light::light(kind, &params, self)?,
            "AreaLightSource" => {
                let area = light::area(kind, params, self)?;
                self.areas.push(area);
                self.state.area = Some(self.areas.len() - 1);
            }
            "Shape" => shape::shape(kind, &params, self)?,
            _ => {}
        }
        Ok(())
    }

    /// The index of a new material.
    fn look(&mut self, class: &str, name: &str, params: &Params) -> Result<usize> {
        let material = material::material(class, params, self)?;
        let mapping = self.mapping.take();
        self.looks.push(Look { material, mapping, name: name.to_owned(), at: params.at.clone() });
        Ok(self.looks.len() - 1)
    }

    fn other(&mut self, word: &str, at: &Place, tokens: &mut Tokens<'_>) -> Result<()> {
        match word {
            "ReverseOrientation" => self.state.is_reversed = !self.state.is_reversed,
            "CoordinateSystem" => {
                let name = tokens.text(word, "its name")?;
                self.systems.insert(name.to_owned(), self.state.ctm);
            }
            "CoordSysTransform" => {
                let name = tokens.text(word, "its name")?;
                let missing = || at.error(word, format!("there is no coordinate system {}", quote(name)));
                self.state.ctm = *self.systems.get(name).ok_or_else(missing)?;
            }
            "NamedMaterial" => {
                let name = tokens.text(word, "its name")?;
                let missing = || at.error(word, format!("there is no material {} above", quote(name)));
                self.state.look = *self.named_looks.get(name).ok_or_else(missing)?;
            }
            "MediumInterface" => {
                let inside = tokens.text(word, "the name of a medium")?;
                let has_outside = matches!(tokens.peek()?, Some(Token::Text(_)));
                let outside = if has_outside { tokens.text(word, "a name")? } else { inside };
                (self.state.inside, self.state.has_outside) = (inside.to_owned(), !outside.is_empty());
                if !outside.is_empty() && outside != inside {
                    self.made.lose(at, word, "the medium outside is not used: media are where their shapes are");
                }
            }
            "ColorSpace" => {
                let name = tokens.text(word, "its name")?;
                require(name == "srgb", || at.error(word, format!("expected srgb, found {}", quote(name))))?;
            }
            "Option" => {
                tokens.text(word, "its name")?;
                tokens.expect(word, "its value")?;
            }
            "WorldEnd" => {}
            "TransformTimes" => _ = tokens.numbers::<2>(word)?,
            "ActiveTransform" => {
                let Some(Token::Word(which @ ("StartTime" | "EndTime" | "All"))) = tokens.next()? else {
                    tokens.is_broken = true;
                    return Err(at.error(word, "expected StartTime, EndTime or All"));
                };
                self.state.is_at_end = which == "EndTime";
                self.made.lose(at, word, "what moves is at rest, where it is when the shutter opens");
            }
            _ => return Err(tokens.broken(word, "this directive is not read")),
        }
        Ok(())
    }
}

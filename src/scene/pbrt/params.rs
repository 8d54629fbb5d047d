//! The parameters of a directive: each is asked for by its name, and those that nobody asks for are errors.

use std::cell::Cell;
use std::path::PathBuf;

use glam::{DVec2, DVec3};

use super::tokens::{Token, Tokens, number_of};
use crate::error::{Error, Result, require};
use crate::printable::{counted, quote};
use crate::scene::imported::{Place, spectrum};
use crate::scene::types::Colour;

#[derive(Clone, Debug)]
pub struct Param {
    kind: String,
    name: String,
    /// The values: numbers, or else words.
    numbers: Vec<f64>,
    words: Vec<String>,
    at: Place,
    used: Cell<bool>,
}

/// The parameters of a directive.
#[derive(Clone, Debug)]
pub struct Params {
    /// The directive with its kind: "Shape sphere".
    pub title: String,
    pub at: Place,
    pub all: Vec<Param>,
}

/// A colour as lights and materials take it.
pub enum Spectrum {
    /// Linear Rec. 709.
    Rgb(Colour),
    /// A curve of wavelengths, whose colour this is for a light, with a luminance of 1, and for a surface.
    Curve {
        light: Colour,
        surface: Colour,
    },
    Named(String),
}

/// The colour of a light with a luminance of 1.
pub fn unit(colour: Colour) -> Colour {
    colour / crate::data::luminance(colour.to_array()).max(f64::MIN_POSITIVE)
}

impl Params {
    /// Reads the parameters that come next.
    pub fn read(title: String, at: Place, tokens: &mut Tokens<'_>) -> Result<Params> {
        let mut all: Vec<Param> = Vec::new();
        while let Some(Token::Text(declared)) = tokens.peek()? {
            tokens.next()?;
            let at = tokens.place();
            let mut words = declared.split_ascii_whitespace();
            let (Some(kind), Some(name), None) = (words.next(), words.next(), words.next()) else {
                return Err(tokens.broken(&title, format!("expected \"type name\", found {}", quote(declared))));
            };
            if all.iter().any(|known| known.name == name) {
                return Err(tokens.broken(&title, format!("{name} is given twice")));
            }
            let (numbers, words) = values(&format!("{title}.{name}"), tokens)?;
            let (kind, name) = (kind.to_owned(), name.to_owned());
            all.push(Param { kind, name, numbers, words, at, used: Cell::new(false) });
        }
        Ok(Params { title, at, all })
    }

    /// Takes spectra of files into the parameters that name them. `resolve` gives the path of a file.
    pub fn with_files(mut self, mut resolve: impl FnMut(&str, &Place) -> PathBuf) -> Result<Params> {
        for param in self.all.iter_mut().filter(|param| param.kind == "spectrum") {
            if let [file] = &param.words[..]
                && file.ends_with(".spd")
            {
                let pairs = spectrum::pairs_of_file(&resolve(file, &param.at));
                let what = format!("{}.{}", self.title, param.name);
                let pairs = pairs.map_err(|reason| param.at.error(&what, reason))?;
                param.numbers = pairs.into_iter().flat_map(|(at, value)| [at, value]).collect();
                param.words.clear();
            }
        }
        Ok(self)
    }

    /// The parameters with those of a default, where they are not given.
    pub fn with_defaults(mut self, defaults: Option<&Vec<Param>>) -> Params {
        for default in defaults.into_iter().flatten() {
            if !self.all.iter().any(|own| own.name == default.name) {
                // Nobody need ask for a default.
                default.used.set(true);
                self.all.push(default.clone());
            }
        }
        self
    }

    pub fn error(&self, message: impl Into<String>) -> Error {
        self.at.error(&self.title, message)
    }

    /// An error at a parameter, or at the directive if it is not there.
    pub fn error_at(&self, name: &str, message: impl Into<String>) -> Error {
        self.place_of(name).error(&format!("{}.{name}", self.title), message)
    }

    pub fn place_of(&self, name: &str) -> &Place {
        self.all.iter().find(|param| param.name == name).map_or(&self.at, |param| &param.at)
    }

    fn find(&self, name: &str, kinds: &[&str]) -> Result<Option<&Param>> {
        let Some(param) = self.all.iter().find(|param| param.name == name) else { return Ok(None) };
        param.used.set(true);
        let wrong = || format!("expected the type {}, found {}", kinds.join(" or "), param.kind);
        require(kinds.contains(&param.kind.as_str()), || self.error_at(name, wrong()))?;
        Ok(Some(param))
    }

    pub fn has(&self, name: &str) -> bool {
        self.all.iter().any(|param| param.name == name)
    }

    /// Parameters that do not change the image.
    pub fn ignore(&self, names: &[&str]) {
        self.all.iter().filter(|param| names.contains(&param.name.as_str())).for_each(|param| param.used.set(true));
    }

    pub fn ignore_all(&self) {
        self.all.iter().for_each(|param| param.used.set(true));
    }

    /// The parameters of a part, which stands before their names, and those of no part. All count as used.
    pub fn of_part(&self, part: &str) -> Params {
        self.ignore_all();
        let own = |param: &Param| match param.name.split_once('.') {
            Some((of, name)) => (of == part).then(|| Param { name: name.to_owned(), ..param.clone() }),
            None => Some(param.clone()),
        };
        Params { all: self.all.iter().filter_map(own).collect(), ..self.clone() }
    }

    pub fn numbers(&self, name: &str, kinds: &[&str]) -> Result<Option<&[f64]>> {
        match self.find(name, kinds)? {
            Some(param) if !param.words.is_empty() => Err(self.error_at(name, "expected numbers")),
            found => Ok(found.map(|param| &param.numbers[..])),
        }
    }

    fn some<const N: usize>(&self, name: &str, kinds: &[&str]) -> Result<Option<[f64; N]>> {
        let found = self.numbers(name, kinds)?;
        let wrong = |found: &[f64]| {
            self.error_at(name, format!("expected {}, found {}", counted(N as u64, "number"), found.len()))
        };
        found.map(|found| <[f64; N]>::try_from(found).map_err(|_| wrong(found))).transpose()
    }

    pub fn number(&self, name: &str) -> Result<Option<f64>> {
        Ok(self.some::<1>(name, &["float"])?.map(|[x]| x))
    }

    pub fn number_or(&self, name: &str, default: f64) -> Result<f64> {
        Ok(self.number(name)?.unwrap_or(default))
    }

    pub fn integer_or(&self, name: &str, default: i64) -> Result<i64> {
        match self.some::<1>(name, &["integer"])? {
            None => Ok(default),
            Some([x]) if x.fract() == 0.0 && x.abs() < 1e15 => Ok(x as i64),
            Some([x]) => Err(self.error_at(name, format!("expected an integer, found {x}"))),
        }
    }

    pub fn point_or(&self, name: &str, default: DVec3) -> Result<DVec3> {
        Ok(self.some::<3>(name, &["point3", "point", "vector3", "vector"])?.map_or(default, DVec3::from_array))
    }

    fn tuples<const N: usize>(&self, name: &str, kinds: &[&str]) -> Result<Vec<[f64; N]>> {
        let all = self.numbers(name, kinds)?.unwrap_or_default();
        let (tuples, rest) = all.as_chunks::<N>();
        let wrong = || format!("expected {N} numbers for each element, found {} numbers", all.len());
        require(rest.is_empty(), || self.error_at(name, wrong()))?;
        Ok(tuples.to_vec())
    }

    pub fn points(&self, name: &str) -> Result<Vec<DVec3>> {
        let kinds = ["point3", "point", "normal3", "normal", "vector3", "vector"];
        Ok(self.tuples::<3>(name, &kinds)?.into_iter().map(DVec3::from_array).collect())
    }

    pub fn points2(&self, name: &str) -> Result<Vec<DVec2>> {
        let kinds = ["point2", "float", "vector2"];
        Ok(self.tuples::<2>(name, &kinds)?.into_iter().map(DVec2::from_array).collect())
    }

    /// The indices of vertices, in groups.
    pub fn indices<const N: usize>(&self, name: &str, vertices: usize) -> Result<Vec<[u32; N]>> {
        let all = self.tuples::<N>(name, &["integer"])?;
        let is_known = |x: &f64| x.fract() == 0.0 && (0.0..vertices as f64).contains(x);
        if let Some(x) = all.iter().flatten().find(|x| !is_known(x)) {
            let message = format!("expected indices of vertices from 0 to below {vertices}, found {x}");
            return Err(self.error_at(name, message));
        }
        Ok(all.into_iter().map(|group| group.map(|x| x as u32)).collect())
    }

    pub fn word(&self, name: &str) -> Result<Option<&str>> {
        self.word_of(name, &["string"])
    }

    fn word_of(&self, name: &str, kinds: &[&str]) -> Result<Option<&str>> {
        match self.find(name, kinds)?.map(|param| &param.words[..]) {
            None => Ok(None),
            Some([word]) => Ok(Some(word)),
            Some(_) => Err(self.error_at(name, "expected one text in quotes")),
        }
    }

    pub fn words(&self, name: &str) -> Result<&[String]> {
        match self.find(name, &["string"])? {
            Some(param) if !param.numbers.is_empty() => Err(self.error_at(name, "expected texts in quotes")),
            found => Ok(found.map_or(&[], |param| &param.words)),
        }
    }

    pub fn flag_or(&self, name: &str, default: bool) -> Result<bool> {
        match self.word_of(name, &["bool"])? {
            None => Ok(default),
            Some("true") => Ok(true),
            Some("false") => Ok(false),
            Some(other) => Err(self.error_at(name, format!("expected true or false, found {}", quote(other)))),
        }
    }

    pub fn is_texture(&self, name: &str) -> bool {
        self.all.iter().any(|param| param.name == name && param.kind == "texture")
    }

    /// The name of the texture that a parameter is, if it is one.
    pub fn texture(&self, name: &str) -> Result<Option<&str>> {
        if self.is_texture(name) { self.word_of(name, &["texture"]) } else { Ok(None) }
    }

    pub fn spectrum(&self, name: &str) -> Result<Option<Spectrum>> {
        let Some(param) = self.find(name, &["rgb", "spectrum", "blackbody", "float"])? else { return Ok(None) };
        Ok(Some(match (param.kind.as_str(), &param.numbers[..], &param.words[..]) {
            ("rgb", &[r, g, b], _) => Spectrum::Rgb(Colour::new(r, g, b)),
            ("rgb", ..) => return Err(self.error_at(name, "expected three numbers")),
            ("float", &[x], _) => Spectrum::Rgb(Colour::splat(x)),
            ("float", ..) => return Err(self.error_at(name, "expected one number")),
            ("blackbody", &[kelvins], _) if kelvins > 0.0 => {
                let light = unit(spectrum::of_black_body(kelvins));
                Spectrum::Curve { light, surface: light }
            }
            ("blackbody", ..) => return Err(self.error_at(name, "expected one temperature above 0 kelvins")),
            (_, _, [named]) => Spectrum::Named(named.clone()),
            (_, all, _) => {
                let (pairs, rest) = all.as_chunks::<2>();
                let pairs: Vec<(f64, f64)> = pairs.iter().map(|[at, value]| (*at, *value)).collect();
                if !rest.is_empty() || !spectrum::rise(&pairs) {
                    return Err(self.error_at(name, "expected one name, or wavelengths that rise, each with its value"));
                }
                let (light, surface) = (spectrum::of_pairs(&pairs, true), spectrum::of_pairs(&pairs, false));
                Spectrum::Curve { light: unit(light), surface }
            }
        }))
    }

    /// A colour that is no light's.
    pub fn colour(&self, name: &str) -> Result<Option<Colour>> {
        match self.spectrum(name)? {
            None => Ok(None),
            Some(Spectrum::Rgb(colour) | Spectrum::Curve { surface: colour, .. }) => Ok(Some(colour)),
            Some(Spectrum::Named(name_of)) => {
                Err(self.error_at(name, format!("the spectrum {} is not read here: give its rgb", quote(&name_of))))
            }
        }
    }

    /// The parameters that nobody has asked for.
    pub fn unused(&self) -> Vec<Error> {
        let unused = self.all.iter().filter(|param| !param.used.get());
        let error = |param: &Param| {
            let message = "this parameter is not read: remove it if the image does not need it";
            param.at.error(&format!("{}.{}", self.title, param.name), message)
        };
        unused.map(error).collect()
    }
}

/// The numbers or the words of a parameter: one, or several in brackets.
fn values(what: &str, tokens: &mut Tokens<'_>) -> Result<(Vec<f64>, Vec<String>)> {
    let expected = "a value, or several in brackets";
    let first = tokens.expect(what, expected)?;
    let is_list = first == Token::Open;
    let mut token = if is_list { tokens.expect(what, "]")? } else { first };
    let (mut numbers, mut words) = (Vec::new(), Vec::new());
    while token != Token::Close || !is_list {
        match (token, number_of(token)) {
            (_, Some(number)) => numbers.push(number),
            (Token::Text(word) | Token::Word(word @ ("true" | "false")), _) => words.push(word.to_owned()),
            _ => return Err(tokens.broken(what, format!("expected {expected}, found {}", token.words()))),
        }
        if !is_list {
            break;
        }
        token = tokens.expect(what, "]")?;
    }
    require(words.is_empty() || numbers.is_empty(), || tokens.broken(what, "expected numbers or texts, found both"))?;
    Ok((numbers, words))
}

//! The notation of the scene file: its forms, their fields and what these take, each declared once. The checks of numbers, the words
//! of error messages and docs/scene.md are made from the declarations.

use super::ValuePath;
use super::numbers::{DEGREES, NO_UNIT, Range};
use crate::error::Result;
use glam::DVec3;

pub const NUMBER: &str = "a number";
pub const PATH: &str = "a file's path in quotes";
pub const POINT: &str = "a point: (x, y, z)";
/// The words in error messages for an expected texture.
pub const TEXTURE: &str = "a texture: Rgb(r, g, b), Checker(..), Image(..), Noise(..) or Marble(..)";

/// What a field takes.
#[derive(Clone, Copy, Debug)]
pub enum Takes {
    /// A number, with its unit.
    Number(Range, &'static str),
    /// An integer, from the first to the last.
    Integer(u32, u32),
    Point,
    Vector,
    /// A colour; the range is that of each channel.
    Colour(Range),
    /// A texture; the range is that of each channel of its colours.
    Texture(Range),
    /// A number that may vary over a surface.
    Varying(Range),
    /// Anything else, in words.
    Other(&'static str),
}

impl Takes {
    /// "a number from 0 to 1"
    pub fn words(&self) -> String {
        match self {
            Takes::Number(range, unit) => {
                let number = if *unit == DEGREES { "a number of degrees" } else { NUMBER };
                match *range {
                    Range::ANY => number.to_owned(),
                    Range::POSITIVE => "a positive number".to_owned(),
                    Range::NOT_NEGATIVE => "0 or a positive number".to_owned(),
                    range => format!("{number} {range}"),
                }
            }
            Takes::Integer(least, most) => format!("a whole number from {least} to {most}"),
            Takes::Point => POINT.to_owned(),
            Takes::Vector => "a vector: (x, y, z)".to_owned(),
            Takes::Colour(_) => "a colour: (r, g, b)".to_owned(),
            Takes::Texture(_) => TEXTURE.to_owned(),
            Takes::Varying(range) => format!("{NUMBER} {range}, or a texture such as Image(path: .., channel: G)"),
            Takes::Other(words) => (*words).to_owned(),
        }
    }

    /// Whether it is a texture.
    pub fn is_texture(&self) -> bool {
        matches!(self, Takes::Texture(_))
    }

    /// Whether it is several numbers in brackets.
    pub fn is_numbers(&self) -> bool {
        matches!(self, Takes::Point | Takes::Vector | Takes::Colour(_))
    }
}

/// A field as the scene file writes it.
#[derive(Debug)]
pub struct Field {
    pub name: &'static str,
    pub takes: Takes,
    /// Its value where the file does not give it, as RON or in words; empty if the file must give it.
    pub default: &'static str,
    /// What it means, for docs/scene.md.
    pub about: &'static str,
}

impl Field {
    /// The field with a name and a meaning, unless it has its own.
    pub const fn named(self, name: &'static str, about: &'static str) -> Field {
        let name = if self.name.is_empty() { name } else { self.name };
        let about = if about.is_empty() { self.about } else { about.trim_ascii_start() };
        Field { name, about, ..self }
    }

    /// Gives the field a default.
    pub const fn or(self, default: &'static str) -> Field {
        Field { default, ..self }
    }

    /// Checks a number; `above` is the path of the form.
    pub fn check(&self, above: &ValuePath, x: f64) -> Result<()> {
        self.check_at(&above.field(self.name), x)
    }

    /// Checks a number that is written without its name; `at` is its own path.
    pub fn check_at(&self, at: &ValuePath, x: f64) -> Result<()> {
        match self.takes {
            Takes::Number(range, unit) => range.check(at, self.name, unit, x),
            Takes::Varying(range) => range.check(at, self.name, NO_UNIT, x),
            _ => Ok(()),
        }
    }

    /// Checks an integer.
    pub fn check_integer(&self, above: &ValuePath, x: u32) -> Result<()> {
        match self.takes {
            Takes::Integer(least, most) if !(least..=most).contains(&x) => {
                Err(above.field(self.name).unexpected(format!("{}: {}", self.name, self.takes.words())))
            }
            _ => Ok(()),
        }
    }
}

/// Declares fields that must be given, by what they take. A field's declaration has its name and its meaning.
macro_rules! fields {
    ($($name:ident($($given:ident: $type:ty),*) => $takes:expr;)*) => {
        $(pub const fn $name($($given: $type),*) -> Field {
            Field { name: "", takes: $takes, default: "", about: "" }
        })*
    };
}

fields! {
    number(range: Range, unit: &'static str) => Takes::Number(range, unit);
    integer(least: u32, most: u32) => Takes::Integer(least, most);
    point() => Takes::Point;
    vector() => Takes::Vector;
    colour(channel: Range) => Takes::Colour(channel);
    texture(channel: Range) => Takes::Texture(channel);
    varying(range: Range) => Takes::Varying(range);
    flag() => Takes::Other("true or false");
    other(words: &'static str) => Takes::Other(words);
}

/// A value of a field. Only numbers have ranges that are checked as they stand.
pub trait Checked {
    /// Refuses a number out of the field's range; `above` is the path of the form.
    fn check_as(&self, _field: &Field, _above: &ValuePath) -> Result<()> {
        Ok(())
    }
}

impl Checked for f64 {
    fn check_as(&self, field: &Field, above: &ValuePath) -> Result<()> {
        field.check(above, *self)
    }
}

impl Checked for u32 {
    fn check_as(&self, field: &Field, above: &ValuePath) -> Result<()> {
        field.check_integer(above, *self)
    }
}

impl Checked for DVec3 {
    fn check_as(&self, field: &Field, above: &ValuePath) -> Result<()> {
        let range = if let Takes::Colour(range) = field.takes { range } else { Range::ANY };
        range.check_each(&above.field(field.name), field.name, *self)
    }
}

impl<T: Checked> Checked for Option<T> {
    fn check_as(&self, field: &Field, above: &ValuePath) -> Result<()> {
        self.as_ref().map_or(Ok(()), |value| value.check_as(field, above))
    }
}

impl Checked for bool {}
impl Checked for (f64, f64) {}
impl Checked for String {}
impl<T> Checked for Vec<T> {}
impl<T> Checked for Box<T> {}

/// A struct or an enum's variant as the scene file writes it.
#[derive(Debug)]
pub struct Form {
    pub name: &'static str,
    /// What it is, for docs/scene.md.
    pub about: &'static str,
    pub fields: &'static [Field],
    /// Whether its fields are written in order, without their names.
    pub in_order: bool,
    /// A small example, for docs/scene.md.
    pub example: &'static str,
}

impl Form {
    /// "Metal(albedo: .., fuzz: ..)"
    pub fn in_full(&self) -> String {
        let write = |field: &Field| match (self.in_order, &field.takes) {
            (false, _) => format!("{}: ..", field.name),
            (true, Takes::Point | Takes::Vector) => "(x, y, z)".to_owned(),
            (true, Takes::Colour(_)) => "(r, g, b)".to_owned(),
            (true, _) => field.name.to_owned(),
        };
        format!("{}({})", self.name, self.fields.iter().map(write).collect::<Vec<_>>().join(", "))
    }

    /// The words for its content where all of it is wrong.
    pub fn content(&self) -> String {
        match self.fields {
            [only] if self.in_order => only.takes.words(),
            _ => self.in_full(),
        }
    }

    pub fn field(&self, name: &str) -> Option<&'static Field> {
        self.fields.iter().find(|field| field.name == name)
    }
}

/// "Rgb(r, g, b), Checker(..) or Image(..)"
pub fn any_of<'a>(forms: impl Iterator<Item = &'a Form>) -> String {
    let short = |form: &Form| if form.in_order { form.in_full() } else { format!("{}(..)", form.name) };
    let all = forms.map(short).collect::<Vec<_>>().join(", ");
    all.rsplit_once("), ").map_or(all.clone(), |(others, last)| format!("{others}) or {last}"))
}

/// "a, b or c"
pub fn any(all: impl Iterator<Item = String>) -> String {
    let all = all.collect::<Vec<_>>().join(", ");
    all.rsplit_once(", ").map_or(all.clone(), |(others, last)| format!("{others} or {last}"))
}

/// Lists the kinds of an enum's values. The number of a value is the index of its kind in the list; kernels switch on
/// it. A variant that the list lacks does not compile.
macro_rules! kinds {
    ($values:ty: $kind:ty; $($variant:ident => $about:expr),* $(,)?) => {
        impl $values {
            pub const KINDS: &'static [$kind] = &[$($about),*];
            /// The names of their shader files.
            const SHADERS: &'static [&'static str] = &[$($about.shader),*];

            /// The index of the value's kind in the list.
            pub fn number(&self) -> usize {
                enum Number {
                    $($variant),*
                }
                match self {
                    $(Self::$variant { .. } => Number::$variant as usize),*
                }
            }

            pub fn kind(&self) -> &'static $kind {
                &Self::KINDS[self.number()]
            }
        }
    };
}

pub(crate) use kinds;

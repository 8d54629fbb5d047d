//! The notation of enum variants in the scene file, for error messages that say what is expected.

pub const NUMBER: &str = "a number";
pub const COLOUR: &str = "a colour: (r, g, b)";
pub const PATH: &str = "a file's path in quotes";
pub const POINT: &str = "a point: (x, y, z)";
pub const VECTOR: &str = "a vector: (x, y, z)";

/// A variant as the scene file writes it.
#[derive(Debug)]
pub struct Form {
    pub name: &'static str,
    /// Its fields, each with a description of the expected value.
    pub fields: &'static [(&'static str, &'static str)],
    /// Whether its fields are written in order, without their names.
    pub in_order: bool,
}

impl Form {
    /// "Metal(albedo: .., fuzz: ..)"
    pub fn in_full(&self) -> String {
        let suffix = if self.in_order { "" } else { ": .." };
        let fields: Vec<String> = self.fields.iter().map(|(field, _)| format!("{field}{suffix}")).collect();
        format!("{}({})", self.name, fields.join(", "))
    }

    /// The description of a field's expected value.
    pub fn expects(&self, field: &str) -> Option<&'static str> {
        self.fields.iter().find(|(known, _)| *known == field).map(|(_, expected)| *expected)
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

            /// The variant's name, as the scene file writes it.
            pub fn name(&self) -> &'static str {
                self.kind().form.name
            }
        }
    };
}

pub(crate) use kinds;

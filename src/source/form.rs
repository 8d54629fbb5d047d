//! How the scene file writes the variants of an enum, for errors that say what is expected.

pub const NUMBER: &str = "a number";
pub const COLOUR: &str = "a colour: (r, g, b)";
pub const PATH: &str = "a file's path in quotes";
pub const POINT: &str = "a point: (x, y, z)";
pub const VECTOR: &str = "a vector: (x, y, z)";

/// A variant as the scene file writes it.
#[derive(Debug)]
pub struct Form {
    pub name: &'static str,
    /// Its fields, each with what is expected there.
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

    /// What is expected of a field.
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

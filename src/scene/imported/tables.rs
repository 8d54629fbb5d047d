//! Tables of measured numbers: .csv files beside this one, of names and their numbers.

/// The eta and the k of metals.
pub const METALS: &str = include_str!("metals.csv");

/// The colours of pbrt's illuminants, with a luminance of 1.
pub const ILLUMINANTS: &str = include_str!("illuminants.csv");

/// The names of a table, each with its numbers as text.
fn lines(table: &'static str) -> impl Iterator<Item = (&'static str, &'static str)> {
    table.lines().filter(|line| !line.starts_with('#')).filter_map(|line| line.split_once(','))
}

fn numbers(text: &str) -> Vec<f64> {
    text.split(',').filter_map(|number| number.parse().ok()).collect()
}

pub fn rows(table: &'static str) -> impl Iterator<Item = Vec<f64>> {
    lines(table).map(|(_, text)| numbers(text))
}

/// The numbers of a name.
pub fn row(table: &'static str, name: &str) -> Option<Vec<f64>> {
    lines(table).find(|(known, _)| *known == name).map(|(_, text)| numbers(text))
}

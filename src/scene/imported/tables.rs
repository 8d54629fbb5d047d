//! Tables of measured numbers: .csv files beside this one, of names and their numbers.

use crate::scene::types::Colour;

/// The eta and the k of metals.
const METALS: &str = include_str!("metals.csv");

/// The indices of refraction of dielectrics.
pub const INDICES: &str = include_str!("indices.csv");

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

/// The eta and the k of a metal.
pub fn metal(name: &str) -> Option<[Colour; 2]> {
    let [a, b, c, d, e, f] = row(METALS, name)?[..] else { return None };
    Some([Colour::new(a, b, c), Colour::new(d, e, f)])
}

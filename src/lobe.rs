//! The lobes of `Pbr`, and its other parts that few materials have: each has one file here with all that the host needs of it, and
//! shaders/lobe/NAME. Also what kernels know of the rows that materials have (`generated/lobes`).

pub mod anisotropy;
mod coat;
pub mod diffuse_transmission;
pub mod dispersion;
mod iridescence;
mod kind;
mod sheen;
mod specular;
pub mod transmission;

use std::fmt::Write as _;

use bytemuck::{Pod, Zeroable};

use crate::data::NO_EXTENSION;
use crate::material::{Material, ROWS, RowKind, Sets};

pub use kind::{Gltf, GltfField, Lobe, To};

/// All lobes. Of the layers, the outer ones come first.
pub const LOBES: &[&Lobe] = &[
    &specular::LOBE,
    &coat::LOBE,
    &sheen::LOBE,
    &transmission::LOBE,
    &anisotropy::LOBE,
    &iridescence::LOBE,
    &diffuse_transmission::LOBE,
    &dispersion::LOBE,
];

/// The lobe with a row of this name as its first.
pub fn lobe_of(name: &str) -> Option<&'static Lobe> {
    LOBES.iter().copied().find(|lobe| lobe.name() == name)
}

/// All kinds of row, in the order in which kernels evaluate them.
pub fn rows() -> impl Iterator<Item = &'static RowKind> {
    ROWS.iter().chain(LOBES.iter().flat_map(|lobe| lobe.rows)).copied()
}

/// Those that kernels evaluate with a material.
pub fn evaluated_rows() -> impl Iterator<Item = &'static RowKind> {
    rows().filter(|row| row.sets != Sets::Nothing)
}

/// The words of `Rows` for rows, so many that its size is a multiple of 16 bytes.
const WORDS: usize = {
    let (mut count, mut i) = (ROWS.len(), 0);
    while i < LOBES.len() {
        count += LOBES[i].rows.len();
        i += 1;
    }
    (3 + count).next_multiple_of(4) - 3
};

/// The rows of a material as kernels have them: what a solid absorbs, and the index of the row of each kind, or [`NO_EXTENSION`].
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Rows {
    pub absorption: [f32; 3],
    indices: [u32; WORDS],
}

impl Rows {
    pub const NONE: Rows = Rows { absorption: [0.0; 3], indices: [NO_EXTENSION; WORDS] };

    /// Says where the row of a kind is.
    pub fn set(&mut self, kind: &RowKind, index: u32) {
        let place = rows().position(|row| row == kind);
        if let Some(own) = place.and_then(|place| self.indices.get_mut(place)) {
            *own = index;
        }
    }
}

/// The module `generated/lobes`: the structs `Rows` and `Lobes`, and for each row that has no module of its own begin_NAME, which says whether
/// a material has one, and take_NAME, which sets what the row is for.
pub fn lobes_module() -> String {
    let mut text = String::from("struct Rows {\n    absorption: vec3<f32>,\n");
    for row in rows() {
        let _ = writeln!(text, "    {}: u32,", row.name);
    }
    text += "}\n\nstruct Lobes {\n";
    for (name, kind) in LOBES.iter().flat_map(|lobe| lobe.members) {
        let _ = writeln!(text, "    {name}: {kind},");
    }
    text += "}\n";
    for row in evaluated_rows().filter(|row| row.sets != Sets::Own) {
        let name = row.name;
        let _ = write!(
            text,
            "
fn begin_{name}(evaluated: ptr<function, EvaluatedMaterial>, own: Rows, front: bool) -> bool {{
    return own.{name} != NO_EXTENSION;
}}

fn take_{name}(evaluated: ptr<function, EvaluatedMaterial>, row: Material, colour: vec3<f32>, is_row: bool) {{
    if is_row {{
{}    }}
}}
",
            sets(row)
        );
    }
    text
}

/// The numbers of materials and of their rows, by name: `${pbr.metallic}` is the member of a `Material` that holds it.
pub fn numbers() -> impl Iterator<Item = (String, String)> {
    let of_kinds =
        Material::KINDS.iter().flat_map(|kind| [(kind.shader, kind.numbers), (kind.shader, kind.second_part)]);
    of_kinds.chain(rows().map(|row| (row.name, row.numbers))).flat_map(|(name, numbers)| {
        let member = move |(number, component)| (format!("{name}.{number}"), format!("numbers.{component}"));
        numbers.iter().zip(["x", "y", "z"]).map(member)
    })
}

/// The statements that set what a row is for. Rounding may have put a number above its largest texel, which is 1 at most.
fn sets(row: &RowKind) -> String {
    let set = |member: &str, value: &str| format!("        (*evaluated).{member} = {value};\n");
    match row.sets {
        Sets::Nothing | Sets::Own => String::new(),
        Sets::Share(member) => set(member, "min(colour.x, 1.0)"),
        Sets::Texel(member) => set(member, "colour"),
        Sets::Lobe => {
            let members = lobe_of(row.name).map_or(&[] as &[_], |lobe| lobe.members);
            let numbers = row.numbers.iter().map(|number| format!("row.${{{}.{number}}}", row.name));
            let values = members.iter().take(1).map(|(_, kind)| match *kind {
                "f32" => "min(colour.x, 1.0)".to_string(),
                _ => "min(colour, vec3<f32>(1.0))".to_string(),
            });
            let values = values.chain(numbers);
            members.iter().zip(values).map(|((member, _), value)| set(&format!("lobes.{member}"), &value)).collect()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_have_names_of_their_own_and_room_for_their_numbers() {
        let mut names: Vec<&str> = rows().map(|row| row.name).collect();
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count, "two rows have one name");
        // A `Material` has three numbers.
        let of_kinds = Material::KINDS.iter().flat_map(|kind| [kind.numbers, kind.second_part]);
        assert!(of_kinds.chain(rows().map(|row| row.numbers)).all(|numbers| numbers.len() <= 3));
        // shaders/lobe/sheen_albedo finds its table behind that of metals.
        assert!(LOBES.iter().filter(|lobe| lobe.table.is_some()).count() <= 1, "a second table has no place");
    }
}

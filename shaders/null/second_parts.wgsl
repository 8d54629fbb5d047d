//@ use data/material
// No material has a second part.
fn second_part_of(material: Material, index: u32) -> Material {
    return material;
}

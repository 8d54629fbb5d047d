//@ implements second_parts when second_part
//@ use bind/materials
// The second part of a material: the next element of the table, if its kind has two.
fn second_part_of(material: Material, index: u32) -> Material {
    switch material.kind {
        //@ each two_part
        case ${number}u: {
            return materials[index + 1u];
        }
        //@ end
        default: {
            return material;
        }
    }
}

//@ without
// No material has a second part.
fn second_part_of(material: Material, index: u32) -> Material {
    return material;
}

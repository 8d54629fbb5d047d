//@ use data/material
// A roughness of a coat that varies over the surface. It comes after the coat.
fn begin_coat_roughness(evaluated: ptr<function, EvaluatedMaterial>, own: Extension, front: bool) -> bool {
    return own.coat_roughness != NO_EXTENSION;
}

fn take_coat_roughness(evaluated: ptr<function, EvaluatedMaterial>, row: Material, colour: vec3<f32>, is_row: bool) {
    let own = (*evaluated).lobes.coat_roughness;
    (*evaluated).lobes.coat_roughness = select(own, min(colour.x, 1.0), is_row);
}

//@ use data/material
// A roughness of the sheen that varies over the surface. It comes after the sheen.
fn begin_sheen_roughness(evaluated: ptr<function, EvaluatedMaterial>, own: Extension, front: bool) -> bool {
    return own.sheen_roughness != NO_EXTENSION;
}

fn take_sheen_roughness(evaluated: ptr<function, EvaluatedMaterial>, row: Material, colour: vec3<f32>, is_row: bool) {
    let own = (*evaluated).lobes.sheen_roughness;
    (*evaluated).lobes.sheen_roughness = select(own, min(colour.x, 1.0), is_row);
}

//@ use data/material
// KHR_materials_transmission: the share of glass in what is no metal. With the metallic share m and the share t, glass is (1 - m) t of all. The
// rest is the base with the metallic share m / (1 - (1 - m) t). It comes after the metallic share.
fn begin_transmission(evaluated: ptr<function, EvaluatedMaterial>, own: Extension, front: bool) -> bool {
    return own.transmission != NO_EXTENSION;
}

fn take_transmission(evaluated: ptr<function, EvaluatedMaterial>, row: Material, colour: vec3<f32>, is_row: bool) {
    if !is_row {
        return;
    }
    let metallic = (*evaluated).material.contrast_inside;
    let glass = (1.0 - metallic) * min(colour.x, 1.0);
    (*evaluated).lobes.transmission = glass;
    (*evaluated).lobes.ior = row.parameter;
    (*evaluated).lobes.contrasts = vec2<f32>(row.contrast_outside, row.contrast_inside);
    (*evaluated).material.contrast_inside = select(metallic, min(metallic / (1.0 - glass), 1.0), glass < 1.0);
}

// KHR_materials_transmission: the share of glass in what is no metal. With the metallic share m and the share t, glass is (1 - m) t of all. The
// rest is the base with the metallic share m / (1 - (1 - m) t). It comes after the metallic share.
fn begin_transmission(evaluated: ptr<function, EvaluatedMaterial>, own: Rows, front: bool) -> bool {
    return own.transmission != NO_EXTENSION;
}

fn take_transmission(evaluated: ptr<function, EvaluatedMaterial>, row: Material, colour: vec3<f32>, is_row: bool) {
    if !is_row {
        return;
    }
    let metallic = (*evaluated).material.${pbr.metallic};
    let glass = (1.0 - metallic) * min(colour.x, 1.0);
    (*evaluated).lobes.transmission = glass;
    (*evaluated).lobes.ior = row.${transmission.ior};
    (*evaluated).lobes.contrasts = vec2<f32>(row.${transmission.outside}, row.${transmission.inside});
    (*evaluated).material.${pbr.metallic} = select(metallic, min(metallic / (1.0 - glass), 1.0), glass < 1.0);
}

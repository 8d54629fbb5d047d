// KHR_materials_anisotropy: red and green are a direction in the axes of the texture coordinates, which the row turns, and blue is a share of
// the strength. Microfacets with one are never smooth. It comes after the roughness.
fn begin_anisotropy(evaluated: ptr<function, EvaluatedMaterial>, own: Rows, front: bool) -> bool {
    return own.anisotropy != NO_EXTENSION;
}

fn take_anisotropy(evaluated: ptr<function, EvaluatedMaterial>, row: Material, colour: vec3<f32>, is_row: bool) {
    let strength = min(colour.z, 1.0) * row.${anisotropy.strength};
    if !is_row || strength == 0.0 {
        return;
    }
    let along = 2.0 * colour.xy - 1.0;
    let cosine = row.${anisotropy.cosine};
    let sine = row.${anisotropy.sine};
    (*evaluated).turn = vec2<f32>(cosine * along.x - sine * along.y, sine * along.x + cosine * along.y);
    (*evaluated).lobes.anisotropy = strength * strength;
    (*evaluated).material.${pbr.roughness} = max((*evaluated).material.${pbr.roughness}, LEAST_ROUGHNESS);
}

//@ implements normal_map when normal
//@ use bind/extensions
//@ use scene/normal_by_map
// Normal maps: images of the normal that a finer surface would have.

// Returns the normal by the map of the surface's material, if it has one. `shading` is the normal without the map, on the side from which
// the ray comes, and `code` is the map's texel.
fn mapped_normal(
    hit: Hit,
    surface: Surface,
    incoming: vec3<f32>,
    shading: vec3<f32>,
    front: bool,
    code: vec3<f32>,
) -> vec3<f32> {
    let row = extensions[surface.material].normal;
    if row == NO_EXTENSION {
        return shading;
    }
    return normal_by_map(row, hit, surface, incoming, shading, front, code);
}

// Whether a direction is on the same side of the surface as of the mapped normal. A map must not let light through a closed surface.
fn keeps_its_side(direction: vec3<f32>, mapped: vec3<f32>, shading: vec3<f32>) -> bool {
    return (dot(direction, mapped) > 0.0) == (dot(direction, shading) > 0.0);
}

// Absorbs a sampled direction that is not.
fn keep_side(bsdf: Scatter, mapped: vec3<f32>, shading: vec3<f32>) -> Scatter {
    if bsdf.event == SCATTERED && !keeps_its_side(bsdf.direction, mapped, shading) {
        return absorbed();
    }
    return bsdf;
}

// Returns 0 for the response to light from such a direction.
fn response_on_side(value: vec3<f32>, direction: vec3<f32>, mapped: vec3<f32>, shading: vec3<f32>) -> vec3<f32> {
    return select(vec3<f32>(0.0), value, keeps_its_side(direction, mapped, shading));
}

//@ without
// No material has a normal map.
fn mapped_normal(
    hit: Hit,
    surface: Surface,
    incoming: vec3<f32>,
    shading: vec3<f32>,
    front: bool,
    code: vec3<f32>,
) -> vec3<f32> {
    return shading;
}

fn keep_side(bsdf: Scatter, mapped: vec3<f32>, shading: vec3<f32>) -> Scatter {
    return bsdf;
}

fn response_on_side(value: vec3<f32>, direction: vec3<f32>, mapped: vec3<f32>, shading: vec3<f32>) -> vec3<f32> {
    return value;
}

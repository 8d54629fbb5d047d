//@ implements coat_normal when coat_normal
//@ use bind/extensions
//@ use scene/normal_by_map
// Normal maps of coats. Without one, a coat has the normal of the surface, and not that of the base's map.
fn coat_normal_at(
    hit: Hit,
    surface: Surface,
    incoming: vec3<f32>,
    shading: vec3<f32>,
    front: bool,
    code: vec3<f32>,
) -> vec3<f32> {
    let row = extensions[surface.material].coat_normal;
    if row == NO_EXTENSION {
        return shading;
    }
    return normal_by_map(row, hit, surface, incoming, shading, front, code);
}

//@ without
// No coat has a normal map.
fn coat_normal_at(
    hit: Hit,
    surface: Surface,
    incoming: vec3<f32>,
    shading: vec3<f32>,
    front: bool,
    code: vec3<f32>,
) -> vec3<f32> {
    return shading;
}

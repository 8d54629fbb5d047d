//@ use data/hit
//@ use data/surface
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

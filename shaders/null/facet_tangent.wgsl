//@ use data/hit
//@ use data/surface
// No material has an anisotropy.
fn facet_tangent(hit: Hit, surface: Surface, normal: vec3<f32>, front: bool, turn: vec2<f32>) -> vec3<f32> {
    return normal;
}

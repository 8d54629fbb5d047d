//@ use data/surface
//@ use data/hit
// For scenes whose textures need no texture coordinates.
fn surface_uv(hit: Hit, point: vec3<f32>, local: vec3<f32>) -> SurfaceUv {
    return SurfaceUv(vec2<f32>(0.0), false);
}

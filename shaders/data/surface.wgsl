// The hit record: where a ray met a surface, as its primitive tells it.
struct Surface {
    // On the surface, in render space; off it by `error` at most, with what the next distance from there is off.
    point: vec3<f32>,
    error: f32,
    // Unit normal on the surface's own side: outwards, or u x v of a quad.
    normal: vec3<f32>,
    material: u32,
    // The place in the primitive's own coordinates: a sphere's normal, a quad's (a, b, 0), in a cuboid 0..1 along each
    // axis from its low corner, the weights of a triangle's vertices.
    local: vec3<f32>,
    // Index of the frame that maps `local` to the object's space for textures.
    frame: u32,
}

const NO_HIT: f32 = -1.0;

// Texture coordinates, and whether u = 1 meets u = 0 there.
struct SurfaceUv {
    uv: vec2<f32>,
    wraps: bool,
}

// A texture. `kind` is its number in the list of textures. Each texture's file defines which parameters it uses.
struct Texture {
    // Checker: the even colour. Others: the factor that the texture's value is multiplied by.
    first: vec3<f32>,
    kind: u32,
    // Checker: the odd colour.
    second: vec3<f32>,
    // Marble: phase of the stripes in radians per unit of the object's z. Image: 1 if it has numbers, 0 if it has colours.
    parameter: f32,
    // Image: the index of its first word, its width, its height, and the number of its texels' format.
    texel: u32,
    width: u32,
    height: u32,
    format: u32,
}

// Maps a point in a primitive's own coordinates (Surface.local) to the point at which a texture is evaluated, in the texture's
// units: origin + x local.x + y local.y + z local.z. The host reduces the origin by the texture's period in f64.
struct Frame {
    x: vec3<f32>,
    // Marble: the stripes' phase at the origin, in [-pi, pi). Image on a mesh: the number of the mesh's table with its texture coordinates,
    // and a quarter for each wrap after the first.
    phase: f32,
    y: vec3<f32>,
    padding0: u32,
    z: vec3<f32>,
    padding1: u32,
    origin: vec3<f32>,
    padding2: u32,
}

// The point at which a texture is evaluated.
struct TexturePoint {
    // In the texture's units. For an image on a sphere: the unit normal in the object's space.
    point: vec3<f32>,
    // Marble: the point's z relative to the frame's origin, and the stripes' phase at that origin (Frame).
    along_z: f32,
    phase: f32,
    // For images only.
    uv: vec2<f32>,
    wraps: vec2<bool>,
}

// The point's offset from the frame's origin.
fn along_frame(frame: Frame, local: vec3<f32>) -> vec3<f32> {
    return local.x * frame.x + local.y * frame.y + local.z * frame.z;
}

// A texture. `kind` is the place of its file in the list of textures; the parameters are each file's own.
struct Texture {
    // Checker: the even colour. Others: what the texture's value is multiplied by.
    first: vec3<f32>,
    kind: u32,
    // Checker: the odd colour.
    second: vec3<f32>,
    // Marble: radians of the stripes per unit of the object's z.
    parameter: f32,
    // Image: its first texel, width and height.
    texel: u32,
    width: u32,
    height: u32,
    padding: u32,
}

// Maps a surface's local place to the point at which a texture is evaluated, in the texture's own units and reduced by
// its period in f64 on the host: origin + x local.x + y local.y + z local.z.
struct Frame {
    x: vec3<f32>,
    // Marble: the stripes' phase at the origin, in [-pi, pi).
    phase: f32,
    y: vec3<f32>,
    padding0: u32,
    z: vec3<f32>,
    padding1: u32,
    origin: vec3<f32>,
    padding2: u32,
}

// Where a texture is evaluated.
struct TexturePoint {
    // In the texture's units; of a sphere under an image, the unit normal in the object's space.
    point: vec3<f32>,
    // The z of the point less that of the frame's origin, and the origin's phase (Frame).
    along_z: f32,
    phase: f32,
    // For images alone.
    uv: vec2<f32>,
    wraps: bool,
}

// The point's offset from the frame's origin.
fn along_frame(frame: Frame, local: vec3<f32>) -> vec3<f32> {
    return local.x * frame.x + local.y * frame.y + local.z * frame.z;
}

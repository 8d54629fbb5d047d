// A participating medium of constant density within a boundary, in render space.
struct Medium {
    // The centre of the boundary, or of a large sphere the point nearest to the camera. The texture is evaluated relative to it.
    center: vec3<f32>,
    // Extinction per unit length.
    density: f32,
    // Albedo, unless a texture replaces it: the scattered fraction of the extinction.
    colour: vec3<f32>,
    // Index of the texture that gives the albedo, or NO_TEXTURE.
    texture: u32,
    // Code of the boundary (data/primitive): a sphere, a cuboid or an instance of a closed mesh.
    boundary: u32,
    frame: u32,
    // Henyey and Greenstein's g, and 1 - |g|, which is rounded once.
    anisotropy: f32,
    one_minus_anisotropy: f32,
}

// Stands for a distance that was not found within the steps allowed per ray.
const WALK_CUT: f32 = -2.0;
// The most steps that all walks through meshes and grids along one ray may take, over all media, where loops have a limit (stage/bounce).
const STEPS_OF_CROSSINGS: u32 = 8000u;
const NO_MEDIUM: u32 = 0xffffffffu;

// A crossing of a ray with a closed mesh.
struct Crossing {
    t: f32,
    // The face's index. Crossings at the same distance are ordered by it.
    face: u32,
    // The winding number of the mesh on the part of the ray before the crossing; 0 is outside.
    winding: i32,
}

// The start of a walk through a mesh: before all crossings.
const AT_ORIGIN: Crossing = Crossing(0.0, 0xffffffffu, 0);

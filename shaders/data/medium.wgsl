// A participating medium of constant density within a boundary, in render space.
struct Medium {
    // The middle of the boundary, from which its texture's places are measured.
    center: vec3<f32>,
    // Extinction per unit of length.
    density: f32,
    // Albedo where no texture replaces it: the scattered share of the extinction.
    colour: vec3<f32>,
    // Index of the texture of the albedo, or NO_TEXTURE.
    texture: u32,
    // The boundary as a primitive's code (data/primitive): a sphere, a cuboid or an instance of a closed mesh.
    boundary: u32,
    frame: u32,
    // Henyey-Greenstein's g, and 1 - |g|, rounded once.
    anisotropy: f32,
    one_minus_anisotropy: f32,
}

// What stands for a distance that could not be found within the steps that a ray may take.
const WALK_CUT: f32 = -2.0;
// Steps of the walks through meshes along one ray at most, in all media together, where loops have a limit (stage/bounce).
const STEPS_OF_CROSSINGS: u32 = 8000u;
const NO_MEDIUM: u32 = 0xffffffffu;

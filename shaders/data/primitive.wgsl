// A code names a BVH node or a primitive in one word. The highest bit is set for a primitive, the next four are its kind, and
// the rest is its index within its kind. The highest codes name no primitive: they say what a slot's path is doing.

const PRIMITIVE_BIT: u32 = 0x80000000u;
const PRIMITIVE_KIND_SHIFT: u32 = 27u;
const PRIMITIVE_INDEX_MASK: u32 = 0x07ffffffu;

// KIND_TRIANGLE is a face of a mesh, or in the mesh's hierarchy a pair of faces. KIND_INSTANCE is an instance of a mesh; the
// walk continues there in the mesh's own space. KIND_DELTA_LIGHT is a light without size, which no ray hits. The other kinds below
// KIND_INSTANCE are shapes. The kind above KIND_INSTANCE belongs to the codes below, which name no primitive.
const KIND_TRIANGLE: u32 = 3u;
const KIND_DELTA_LIGHT: u32 = 13u;
const KIND_INSTANCE: u32 = 14u;

// The ray left the scene.
const HIT_NOTHING: u32 = 0xffffffffu;
// The path has ended. `throughput` now holds its radiance.
const PATH_ENDED: u32 = 0xfffffffeu;
// The slot has no run.
const SLOT_IDLE: u32 = 0xfffffffdu;
// The slot's ray is not traced yet.
const RAY_READY: u32 = 0xfffffffcu;
// The walk through the BVH took too many steps and was given up. The path's sample is rejected.
const PATH_CUT: u32 = 0xfffffffbu;
// The path reached max_depth before it ended. `throughput` still holds its throughput.
const PATH_TOO_DEEP: u32 = 0xfffffffau;
const FIRST_STATUS: u32 = PATH_TOO_DEEP;

fn primitive_kind(code: u32) -> u32 {
    return (code >> PRIMITIVE_KIND_SHIFT) & 15u;
}

fn primitive_index(code: u32) -> u32 {
    return code & PRIMITIVE_INDEX_MASK;
}

// A BVH node: the boxes of up to four children, and their codes. Each plane of a box is one byte, a position on the node's own grid:
// origin + byte * scale. The host makes sure that this sum, rounded as the kernel rounds it, lies outside what the box bounds.
struct Node {
    // The bits of the grid's origin. In the last word, the low three bytes are the biased binary exponents of the grid's scale along x, y
    // and z, and the high byte is the number of children. It is one vector, because llvmpipe reads a vector faster than its parts.
    grid: vec4<u32>,
    // The lower planes along x, y and z: one byte per child.
    low: vec3<u32>,
    padding0: u32,
    // The upper planes, likewise.
    high: vec3<u32>,
    padding1: u32,
    // The codes of the children; or the place of the first one (scene/siblings).
    children: vec4<u32>,
}

struct Sphere {
    center: vec3<f32>,
    radius: f32,
    // Index in the scene's order of primitives. Of two hits at the same distance, the primitive with the lower index wins.
    order: u32,
    material: u32,
    frame: u32,
    // Its index in the table of lights, if it is a light.
    light: u32,
}

// A sphere that is large against its distance from the camera. With x relative to `nearest`, a point is on it if curvature x² - 2
// inward . x = 0. Near the camera, these numbers are small and keep their digits, however large the sphere is.
struct LargeSphere {
    // Its point nearest to the camera.
    nearest: vec3<f32>,
    // 1 over the radius.
    curvature: f32,
    // Unit normal at that point, towards the centre.
    inward: vec3<f32>,
    // Index in the scene's order of primitives.
    order: u32,
    material: u32,
    frame: u32,
    // Its index in the table of lights, if it is a light.
    light: u32,
    // 1 if the point that was nearest is its own point where it moves, 0 if the centre is (motion/large_sphere).
    follows_nearest: u32,
}

// A parallelogram corner + a u + b v with 0 <= a, b <= 1, where a = (p - corner) . a_axis and b = (p - corner) . b_axis. A disk is stored
// as the square around it.
struct Quad {
    corner: vec3<f32>,
    order: u32,
    normal: vec3<f32>,
    material: u32,
    a_axis: vec3<f32>,
    frame: u32,
    b_axis: vec3<f32>,
    // Bound of the rounding error of a point on the quad, in render space.
    error: f32,
    u: vec3<f32>,
    // Its index in the table of lights, if it is a light.
    light: u32,
    v: vec3<f32>,
    // Bound of that error along the normal, plus the error of the next distance to the quad that is computed from the point.
    error_across: f32,
}

// A cuboid around `center`. `half_extent` holds half its edge lengths along the unit vectors x_axis, y_axis and x_axis × y_axis.
struct Cuboid {
    center: vec3<f32>,
    order: u32,
    half_extent: vec3<f32>,
    material: u32,
    x_axis: vec3<f32>,
    frame: u32,
    y_axis: vec3<f32>,
    // Its index in the table of lights, if it is a light.
    light: u32,
}

// A mesh rotated, scaled and moved from its own space to render space. In its own space, its box is centred on the
// origin and has an extent near 1.
struct Instance {
    // The mesh's x and y axes in render space. Its z axis is x × y.
    x_axis: vec3<f32>,
    order: u32,
    y_axis: vec3<f32>,
    material: u32,
    // The mesh's origin in render space.
    translation: vec3<f32>,
    frame: u32,
    scale: f32,
    // A face's index plus this is the face's index in the table of lights, if it is a light.
    to_light: u32,
    // Code of the root of the mesh's BVH.
    root: u32,
    // A vertex's index plus this is the index of its texture coordinates and its colour in `meshes`; or NO_UVS. A vertex's index plus a
    // multiple of this is its index in a further table.
    to_uvs: u32,
}

// Two faces of a mesh that share two corners, or one face. The low three words of a, b, c and d are the positions of the corners in the
// mesh's space; a, b and c are the corners of the first face. The high words of a and b are the codes of both faces, or NO_FACE instead of
// the second. That of c holds the corners of the second face in their order: two bits each, 0 for a to 3 for d.
struct FacePair {
    a: vec4<u32>,
    b: vec4<u32>,
    c: vec4<u32>,
    d: vec4<u32>,
}

const NO_FACE: u32 = 0u;
const NO_UVS: u32 = 0xffffffffu;
// Stands for a vertex normal in flat-shaded meshes.
const NO_NORMAL: u32 = 0x80008000u;

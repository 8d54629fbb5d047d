// A code names a BVH node or a primitive in one word: the highest bit tells a primitive, the next three its kind, the
// rest its index among its kind. The highest codes name no primitive; they say what a slot's path is doing.

const PRIMITIVE_BIT: u32 = 0x80000000u;
const PRIMITIVE_KIND_SHIFT: u32 = 28u;
const PRIMITIVE_INDEX_MASK: u32 = 0x0fffffffu;

// A face of a mesh; and a mesh placed in the scene, below which the walk goes on in the mesh's own space. The kinds before an instance are
// shapes; the one behind it is that of the codes below.
const KIND_TRIANGLE: u32 = 3u;
const KIND_INSTANCE: u32 = 6u;

// The ray left the scene.
const HIT_NOTHING: u32 = 0xffffffffu;
// The path ended; its radiance stands where its throughput stood.
const PATH_ENDED: u32 = 0xfffffffeu;
// The slot has no run.
const SLOT_IDLE: u32 = 0xfffffffdu;
// The slot's ray has yet to be traced.
const RAY_READY: u32 = 0xfffffffcu;
// The walk through the BVH was given up as too long: the path is worth nothing.
const PATH_CUT: u32 = 0xfffffffbu;
// The path would have gone on beyond max_depth; its throughput stands where it stood.
const PATH_TOO_DEEP: u32 = 0xfffffffau;
const FIRST_STATUS: u32 = PATH_TOO_DEEP;

fn primitive_kind(code: u32) -> u32 {
    return (code >> PRIMITIVE_KIND_SHIFT) & 7u;
}

fn primitive_index(code: u32) -> u32 {
    return code & PRIMITIVE_INDEX_MASK;
}

// A BVH node: the boxes of up to four children and their codes. A box's planes are bytes of a grid of the node's own:
// origin + byte * scale, where the host has made sure that this sum, rounded as here, lies outside what the box bounds.
struct Node {
    origin: vec3<f32>,
    // Biased binary exponents of the grid's scale along x, y and z in the low three bytes; the children's number above.
    exponents: u32,
    // The lower planes along x, y and z: a byte a child.
    low: vec3<u32>,
    padding0: u32,
    // The upper planes.
    high: vec3<u32>,
    padding1: u32,
    // Codes of the children.
    children: vec4<u32>,
}

struct Sphere {
    center: vec3<f32>,
    radius: f32,
    // Place among the scene's primitives: of two hits at one distance the lower wins.
    order: u32,
    material: u32,
    frame: u32,
    // Its place among the lights, if it is one.
    light: u32,
}

// A parallelogram corner + a u + b v, 0 <= a, b <= 1; a = (p - corner) . a_axis, and b likewise.
struct Quad {
    corner: vec3<f32>,
    order: u32,
    normal: vec3<f32>,
    material: u32,
    a_axis: vec3<f32>,
    frame: u32,
    b_axis: vec3<f32>,
    // Bound of the error of a point on the quad, in render space.
    error: f32,
    u: vec3<f32>,
    // Its place among the lights, if it is one.
    light: u32,
    v: vec3<f32>,
    // Bound of that error along the normal, and of the next distance's from there.
    error_across: f32,
}

// A cuboid about `center` with half its edges along the unit vectors x_axis, y_axis and x_axis × y_axis.
struct Cuboid {
    center: vec3<f32>,
    order: u32,
    half_extent: vec3<f32>,
    material: u32,
    x_axis: vec3<f32>,
    frame: u32,
    y_axis: vec3<f32>,
    // Its place among the lights, if it is one.
    light: u32,
}

// A mesh placed in render space: turned, scaled and moved there from its own space, in which its box stands about the
// origin with an extent near 1.
struct Instance {
    // The mesh's x and y in render space; its z is x × y.
    x_axis: vec3<f32>,
    order: u32,
    y_axis: vec3<f32>,
    material: u32,
    // Where the mesh's origin stands.
    place: vec3<f32>,
    frame: u32,
    scale: f32,
    // From a face's index to its place among the lights, if it is one.
    to_light: u32,
    // Code of the mesh's root (data/primitive).
    root: u32,
    // From a vertex to its texture coordinates in `meshes`, or NO_UVS.
    to_uvs: u32,
}

const NO_UVS: u32 = 0xffffffffu;
// What stands for the normal of a vertex of a flat-shaded mesh.
const NO_NORMAL: u32 = 0x80008000u;

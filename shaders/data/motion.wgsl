// Motions: how objects move while the shutter is open. The table of motions is rows of four words:
// - its head: the first row of the camera's keys, their number (0 if the camera rests), and the number of objects before lights without size;
// - one row for each object, by its place in the order of the scene: the first row of its steps, and their number, 0 if it rests. Behind the
//   primitives, each medium has two: that of its boundary and that of its texture. Lights without size follow;
// - the steps, two rows each, and their keys.

// In the order of an object: it moves.
const MOVES: u32 = 0x80000000u;

// A step has two rows. The first is the way from the point that it keeps in place to the object's own point at rest, in render space; its last
// word is the step's kind and, above two bits, the number of its keys. The second is the axis of a spin, a unit vector, and the first row of the keys.
// Steps apply in their order.

// The values of a step's keys. A row has the time in its last word, 0 where the shutter opens and 1 where it closes.
// A shift: x, y and z.
const SHIFT: u32 = 0u;
// A spin around an axis: half the angle, in turns.
const SPIN: u32 = 1u;
// A factor of the size, minus 1.
const RESIZE: u32 = 2u;
// A turn: the vector of a unit quaternion. Each key has a second row, which begins with its scalar.
const TURN: u32 = 3u;
const KIND_OF_STEP: u32 = 3u;
const KEYS_SHIFT: u32 = 2u;

// A similarity around an object's own point: that point is shifted, and the object is turned and scaled around it.
struct Pose {
    shift: vec3<f32>,
    scale: f32,
    // A unit quaternion, the scalar last.
    turn: vec4<f32>,
    // Whether the object moves. Otherwise it is as its element says, and the rest is of no account.
    moves: bool,
}

// The state of the slots' paths: planes of one vec4 a slot, laid plane after plane (data/path says what they hold).
// Integers, because a float store may flush or change bits that mean something else.
@group(0) @binding(4) var<storage, read_write> paths: array<vec4<u32>>;

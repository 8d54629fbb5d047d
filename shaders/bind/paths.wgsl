// The state of the slots' paths (slots/state). Its elements are integers, because a float store may flush or
// change bits that are not a number.
@group(0) @binding(4) var<storage, read_write> paths: array<vec4<u32>>;

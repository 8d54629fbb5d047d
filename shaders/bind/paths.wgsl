// The state of the slots' paths (slots/state). Integers, because a float store may flush or change bits that mean something else.
@group(0) @binding(4) var<storage, read_write> paths: array<vec4<u32>>;

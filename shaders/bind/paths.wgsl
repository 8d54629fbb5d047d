// The state of the slots' paths (slots/state). Its elements are integers, because storing other bits as a float may flush or change them.
@group(0) @binding(4) var<storage, read_write> paths: array<vec4<u32>>;

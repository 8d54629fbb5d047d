// For each queue: the three sizes of its indirect dispatch, and the number of slots in it.
@group(0) @binding(14) var<storage, read_write> queue_args: array<vec4<u32>>;

// queue_args as the queued kernels read it: a buffer of indirect sizes may not be written where it is used.
@group(0) @binding(14) var<storage, read> queue_args: array<vec4<u32>>;

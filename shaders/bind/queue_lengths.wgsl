// queue_args for the queued kernels, read-only: a dispatch may not write the buffer that its indirect sizes come from.
@group(0) @binding(14) var<storage, read> queue_args: array<vec4<u32>>;

// The slots that wait for the scatter kernels: first the length of each queue, then the queues. Each queue has room for all slots.
@group(0) @binding(13) var<storage, read_write> queues: array<atomic<u32>>;

// Slots waiting for the scatter kernels: the length of each queue, then the queues, each with room for every slot.
@group(0) @binding(13) var<storage, read_write> queues: array<atomic<u32>>;

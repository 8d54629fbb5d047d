// The layout of the queues' buffer: the header holds the length of each queue, and the queues follow.
const QUEUE_HEADER: u32 = 16u;

fn queue_index(queue: u32, index: u32, slots: u32) -> u32 {
    return QUEUE_HEADER + queue * slots + index;
}

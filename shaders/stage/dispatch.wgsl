//@ use bind/queues
//@ use bind/queue_args
// Turns the queues' lengths into the sizes of the scatter dispatches, and empties the queues for the next bounce.
override WORKGROUP_SIZE: u32 = 64u;
const QUEUES: u32 = ${queues}u;

@compute @workgroup_size(1)
fn dispatch() {
    for (var queue = 0u; queue < QUEUES; queue++) {
        let waiting = atomicExchange(&queues[queue], 0u);
        queue_args[queue] = vec4<u32>((waiting + WORKGROUP_SIZE - 1u) / WORKGROUP_SIZE, 1u, 1u, waiting);
    }
}

//@ implements queued_slot when queues
//@ use bind/queues
//@ use bind/queue_lengths
//@ use bind/settings
//@ use bind/window
// For one scatter kernel per material: each slot in the material's queue has an invocation. Invocations past the
// end of the queue have no slot.
const QUEUE: u32 = ${queue}u;

fn queued_slot(index: u32) -> u32 {
    if index >= queue_args[QUEUE].w {
        return window.end_slot;
    }
    return atomicLoad(&queues[queue_index(QUEUE, index, settings.slots)]);
}

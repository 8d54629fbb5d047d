//@ use bind/queues
//@ use bind/queue_turns
//@ use bind/settings
//@ use data/queue
// For one scatter kernel per material: each slot in the material's queue has an invocation. Invocations past the
// end of the queue have no slot.
const QUEUE: u32 = ${queue}u;

fn queued_slot(turn: u32) -> u32 {
    if turn >= queue_args[QUEUE].w {
        return settings.slots;
    }
    return atomicLoad(&queues[queue_place(QUEUE, turn, settings.slots)]);
}

//@ use bind/queues
//@ use bind/queue_turns
//@ use bind/settings
//@ use data/queue
// One scatter kernel for each material: an invocation for each slot in its queue. Turns past the end name no slot.
const QUEUE: u32 = ${queue}u;

fn queued_slot(turn: u32) -> u32 {
    if turn >= queue_args[QUEUE].w {
        return settings.slots;
    }
    return atomicLoad(&queues[queue_place(QUEUE, turn, settings.slots)]);
}

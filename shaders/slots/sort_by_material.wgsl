//@ implements queue_of_hits when queues & !medium
//@ implements queue_of_events when queues
//@ use bind/queues
//@ use bind/settings
//@ use choice/mix
// Puts a slot whose ray hit a surface into the queue of that surface's material.

// Takes the next place of the queue of a kind. Each case has a counter of its own, at an address that is the same for all invocations: drivers
// then add once for each subgroup (docs/dev/gpu-kernels.md).
fn place_in_queue(kind: u32) -> u32 {
    switch kind {
        //@ each material
        ${case}: {
            return queue_index(${rank}u, atomicAdd(&queues[${rank}u], 1u), settings.slots);
        }
        //@ end
    }
}

fn sort_slot(slot: u32, path: ptr<function, Path>) {
    let hit = path_hit(path);
    if hit.code >= FIRST_STATUS {
        return;
    }
    let place = place_in_queue(kind_of_event(path, hit));
    atomicStore(&queues[place], slot);
}

//@ without
// Slots are not sorted here.
fn sort_slot(slot: u32, path: ptr<function, Path>) {
}

//@ use data/hit
//@ use bind/queues
//@ use bind/materials
//@ use bind/settings
//@ use data/queue
//@ use data/primitive
//@ use scene/surfaces
// Puts a slot whose ray hit a surface into the queue of that surface's material.

fn queue_of(kind: u32) -> u32 {
    switch kind {
        //@ each material
        ${case}: {
            return ${rank}u;
        }
        //@ end
    }
}

fn sort_slot(slot: u32, hit: Hit) {
    if hit.code >= FIRST_STATUS {
        return;
    }
    let queue = queue_of(materials[material_index(hit)].kind);
    let index = atomicAdd(&queues[queue], 1u);
    atomicStore(&queues[queue_index(queue, index, settings.slots)], slot);
}

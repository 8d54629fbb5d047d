//@ implements shadow_slot when light & !fused
// The shadow ray of a slot's path, from the stage that sends it to the one that traces it.

fn store_no_light(slot: u32) {
    store_light(slot, NO_LIGHT);
}

// If the path has one.
fn store_shadow_ray(slot: u32, path: ptr<function, Path>) {
    if (*path).light != NO_LIGHT {
        store_shadow(slot, path);
        store_light_weight(slot, path);
    }
}

//@ without
// No stage hands shadow rays to another.
fn store_no_light(slot: u32) {
}

fn store_shadow_ray(slot: u32, path: ptr<function, Path>) {
}

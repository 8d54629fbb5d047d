//@ use step/trace
//@ use bind/window
//@ use choice/aov_hit_slot
//@ use choice/walker_slot
//@ use choice/time
//@ use choice/pane_slot
//@ use choice/queue_of_hits
// Finds the nearest hit of each slot's ray.
override WORKGROUP_SIZE: u32 = 64u;

@compute @workgroup_size(WORKGROUP_SIZE)
fn intersect(@builtin(global_invocation_id) id: vec3<u32>) {
    let slot = window.first_slot + id.x;
    if slot >= window.end_slot {
        return;
    }
    var path: Path;
    load_ray(slot, &path);
    if path.status == SLOT_IDLE {
        return;
    }
    load_walker(slot, &path);
    begin_time(&path);
    trace(&path);
    store_passed(slot, &path);
    record_hit_of_slot(slot, &path);
    store_status(slot, path.status);
    store_hit(slot, &path);
    sort_slot(slot, &path);
}

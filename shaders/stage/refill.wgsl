//@ use slots/state
//@ use step/refill
//@ use bind/window
// Adds ended paths to their runs, and refills their slots.
override WORKGROUP_SIZE: u32 = 64u;

@compute @workgroup_size(WORKGROUP_SIZE)
fn refill(@builtin(global_invocation_id) id: vec3<u32>) {
    let slot = window.first_slot + id.x;
    if slot >= window.end_slot || !has_ended(load_status(slot)) {
        return;
    }
    var path: Path;
    load_path(slot, &path);
    refill_path(&path);
    store_path(slot, &path);
}

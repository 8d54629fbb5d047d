//@ use slots/state
//@ use step/start
//@ use bind/window
//@ use choice/shadow_slot
// Gives every slot its first run.
override WORKGROUP_SIZE: u32 = 64u;

@compute @workgroup_size(WORKGROUP_SIZE)
fn generate(@builtin(global_invocation_id) id: vec3<u32>) {
    let slot = window.first_slot + id.x;
    if slot >= window.end_slot {
        return;
    }
    var path: Path;
    if start_run(&path) {
        start_sample(&path);
    }
    store_path(slot, &path);
    store_no_light(slot);
}

//@ use slots/state
//@ use step/start
//@ use choice/shadow_slot
// Gives every slot its first run.
override WORKGROUP_SIZE: u32 = 64u;

@compute @workgroup_size(WORKGROUP_SIZE)
fn generate(@builtin(global_invocation_id) id: vec3<u32>) {
    let slot = id.x;
    if slot >= settings.slots {
        return;
    }
    var path: Path;
    start_run(&path);
    store_path(slot, &path);
    store_no_light(slot);
}

//@ use slots/state
//@ use step/light
// Traces the slots' shadow rays, and takes in the light that they find.
override WORKGROUP_SIZE: u32 = 64u;

@compute @workgroup_size(WORKGROUP_SIZE)
fn shadow(@builtin(global_invocation_id) id: vec3<u32>) {
    let slot = id.x;
    if slot >= settings.slots || load_light(slot) == NO_LIGHT {
        return;
    }
    var path: Path;
    load_path(slot, &path);
    trace_shadow(&path);
    store_path(slot, &path);
}

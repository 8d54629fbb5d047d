//@ use slots/shadow
//@ use bind/window
//@ use step/light
//@ use choice/walker_slot
//@ use choice/time
//@ use choice/aov_direct_slot
//@ use choice/probe_slot
// Traces the shadow rays, and adds the light that they find.
override WORKGROUP_SIZE: u32 = 64u;

@compute @workgroup_size(WORKGROUP_SIZE)
fn shadow(@builtin(global_invocation_id) id: vec3<u32>) {
    let slot = window.first_slot + id.x;
    if slot >= window.end_slot || load_light(slot) == NO_LIGHT {
        return;
    }
    var path: Path;
    load_shadow(slot, &path);
    load_walker(slot, &path);
    begin_time(&path);
    let limit = limit_of_shadow(&path);
    let hit = shadow_hit(&path, limit);
    // What the walk does not need is loaded after it, so that the walk has the registers.
    path.status = load_status(slot);
    load_light_weight(slot, &path);
    load_radiance(slot, &path);
    path.rays = load_rays(slot);
    load_counted_path(slot, &path);
    load_direct_of_slot(slot, &path);
    add_light_of_shadow(&path, limit, hit);
    store_direct(slot, &path);
    store_radiance(slot, &path);
    store_rays(slot, path.rays);
    store_no_light(slot);
    if path.status == PATH_CUT {
        store_status(slot, PATH_CUT);
    }
}

//@ use step/media
//@ use bind/window
//@ use choice/shadow_slot
//@ use choice/time
//@ use choice/queue_of_events
// Lets media scatter the paths before they reach their hits.
override WORKGROUP_SIZE: u32 = 64u;

@compute @workgroup_size(WORKGROUP_SIZE)
fn medium(@builtin(global_invocation_id) id: vec3<u32>) {
    let slot = window.first_slot + id.x;
    if slot >= window.end_slot {
        return;
    }
    var path: Path;
    load_ray(slot, &path);
    load_hit(slot, &path);
    if path.status == SLOT_IDLE {
        return;
    }
    path.light = NO_LIGHT;
    load_throughput(slot, &path);
    load_sample_of_path(slot, &path);
    begin_time(&path);
    load_radiance(slot, &path);
    load_direct(slot, &path);
    load_aov_surface(slot, &path);
    cross_media(&path, 0u);
    store_aov_surface(slot, &path);
    store_direct(slot, &path);
    store_radiance(slot, &path);
    store_shadow_ray(slot, &path);
    store_ray(slot, &path);
    store_throughput(slot, &path);
    sort_slot(slot, &path);
}

//@ use slots/between
//@ use step/media
//@ if queue
//@ use slots/sort_by_material
//@ end
// Lets media scatter the paths before they reach their hits.
override WORKGROUP_SIZE: u32 = 64u;

@compute @workgroup_size(WORKGROUP_SIZE)
fn medium(@builtin(global_invocation_id) id: vec3<u32>) {
    let slot = id.x;
    if slot >= settings.slots {
        return;
    }
    var path: Path;
    load_hit(slot, &path);
    if path.status == SLOT_IDLE {
        return;
    }
    load_throughput(slot, &path);
    load_sample_of_path(slot, &path);
    //@ if light
    load_radiance(slot, &path);
    path.light = NO_LIGHT;
    //@ end
    //@ if aov_surface
    load_aov_surface(slot, &path);
    //@ end
    cross_media(&path);
    //@ if aov_surface
    store_aov_surface(slot, &path);
    //@ end
    //@ if light
    store_radiance(slot, &path);
    if path.light != NO_LIGHT {
        store_shadow(slot, &path);
    }
    //@ end
    store_ray(slot, &path);
    store_throughput(slot, &path);
    //@ if queue
    sort_slot(slot, path_hit(&path));
    //@ end
}

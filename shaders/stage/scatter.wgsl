//@ use slots/between
//@ use step/scatter
//@ if queue
//@ use slots/queue_turn
//@ end
// Scatters the paths that hit a surface.
override WORKGROUP_SIZE: u32 = 64u;

@compute @workgroup_size(WORKGROUP_SIZE)
fn scatter(@builtin(global_invocation_id) id: vec3<u32>) {
    var slot = id.x;
    //@ if queue
    slot = queued_slot(id.x);
    //@ end
    if slot >= settings.slots {
        return;
    }
    var path: Path;
    load_hit(slot, &path);
    if path.status >= FIRST_STATUS {
        return;
    }
    load_throughput(slot, &path);
    load_sample_of_path(slot, &path);
    //@ if gathers
    load_radiance(slot, &path);
    //@ end
    //@ if sends_shadow_ray
    path.light = NO_LIGHT;
    //@ end
    //@ if aov_surface
    load_aov_surface(slot, &path);
    //@ end
    scatter_path(&path);
    //@ if aov_surface
    store_aov_surface(slot, &path);
    //@ end
    //@ if gathers
    store_radiance(slot, &path);
    //@ end
    //@ if sends_shadow_ray
    if path.light != NO_LIGHT {
        store_shadow(slot, &path);
    }
    //@ end
    store_ray(slot, &path);
    store_throughput(slot, &path);
}

//@ use slots/between
//@ use step/trace
//@ if aov_hit
//@ use step/aov_hit
//@ end
//@ if queue_of_hits
//@ use slots/sort_by_material
//@ end
// Finds the nearest hit of each slot's ray.
override WORKGROUP_SIZE: u32 = 64u;

@compute @workgroup_size(WORKGROUP_SIZE)
fn intersect(@builtin(global_invocation_id) id: vec3<u32>) {
    let slot = id.x;
    if slot >= settings.slots {
        return;
    }
    var path: Path;
    load_ray(slot, &path);
    if path.status == SLOT_IDLE {
        return;
    }
    //@ if alpha
    load_throughput(slot, &path);
    load_sample_of_path(slot, &path);
    //@ end
    trace(&path);
    //@ if aov_hit
    load_throughput(slot, &path);
    load_sample_of_path(slot, &path);
    load_aov_hit(slot, &path);
    note_hit(&path);
    store_aov_hit(slot, &path);
    //@ end
    store_hit(slot, &path);
    //@ if queue_of_hits
    sort_slot(slot, path_hit(&path));
    //@ end
}

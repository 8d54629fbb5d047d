//@ use slots/state
//@ use step/trace
//@ use step/refill
//@ use bind/window
//@ use choice/aov_hit
//@ use choice/media
//@ use choice/scatter
//@ use choice/shadow
//@ use choice/time
//@ relies on loops
// Intersects, crosses media, scatters and refills in one kernel, with several bounces per dispatch. It is for devices where
// storing and loading a path's state costs more than divergence, such as software drivers.
override WORKGROUP_SIZE: u32 = 64u;

// After this many loop iterations, an invocation leaves its other bounces to the next dispatch. Even with the longest walks that
// may still follow (scene/traverse, step/media), the total stays below the 65,535 iterations that Mesa 22.3 allows an invocation.
const MOST_ITERATIONS: u32 = 16384u;

@compute @workgroup_size(WORKGROUP_SIZE)
fn bounce(@builtin(global_invocation_id) id: vec3<u32>) {
    let slot = window.first_slot + id.x;
    if slot >= window.end_slot || load_status(slot) == SLOT_IDLE {
        return;
    }
    var path: Path;
    load_path(slot, &path);
    var iterations = MOST_STEPS_OF_MEDIA;
    for (var i = 0u; i < window.bounces && iterations < MOST_ITERATIONS; i++) {
        begin_time(&path);
        iterations += trace(&path) + ITERATIONS_OF_SHADING;
        record_hit(&path);
        iterations = cross_media(&path, iterations);
        if path.status < FIRST_STATUS {
            scatter_path(&path);
        }
        iterations = trace_shadow(&path, iterations);
        if has_ended(path.status) {
            refill_path(&path);
            if path.status == SLOT_IDLE {
                break;
            }
        }
    }
    store_path(slot, &path);
}

//@ use slots/state
//@ use step/trace
//@ if aov_hit
//@ use step/aov_hit
//@ end
//@ if medium
//@ use step/media
//@ end
//@ if surface
//@ use step/scatter
//@ end
//@ use step/refill
//@ relies on loops
// Intersects, crosses media, scatters and refills in one kernel, with several bounces per dispatch. It is for devices where
// storing and loading a path's state costs more than divergence, such as software drivers.
override WORKGROUP_SIZE: u32 = 64u;

// After this many loop iterations, an invocation leaves its other bounces to the next dispatch. Even with the longest walks that
// may still follow (scene/traverse, step/media), the total stays below the 65,535 iterations that Mesa 22.3 allows an invocation.
const MOST_ITERATIONS: u32 = 16384u;
//@ if undetailed
// The most iterations that shading takes: seven octaves of noise over eight corners.
const ITERATIONS_OF_SHADING: u32 = 64u;
//@ end
//@ if detailed
// The most iterations that shading takes: seven octaves of noise over eight corners, for five textures of a material and one of a light.
const ITERATIONS_OF_SHADING: u32 = 384u;
//@ end

@compute @workgroup_size(WORKGROUP_SIZE)
fn bounce(@builtin(global_invocation_id) id: vec3<u32>) {
    let slot = id.x;
    if slot >= settings.slots || load_status(slot) == SLOT_IDLE {
        return;
    }
    var path: Path;
    load_path(slot, &path);
    var iterations = 0u;
    //@ if medium
    iterations = MOST_STEPS_OF_MEDIA;
    //@ end
    for (var i = 0u; i < window.bounces && iterations < MOST_ITERATIONS; i++) {
        iterations += trace(&path) + ITERATIONS_OF_SHADING;
        //@ if aov_hit
        note_hit(&path);
        //@ end
        //@ if medium
        iterations += cross_media(&path);
        //@ end
        //@ if surface
        if path.status < FIRST_STATUS {
            scatter_path(&path);
        }
        //@ end
        //@ if light
        if path.light != NO_LIGHT {
            iterations += trace_shadow(&path);
        }
        //@ end
        if has_ended(path.status) {
            refill_path(&path);
            if path.status == SLOT_IDLE {
                break;
            }
        }
    }
    store_path(slot, &path);
}

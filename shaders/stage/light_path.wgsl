//@ use slots/state
//@ use step/trace
//@ use light_path/scatter
//@ use bind/window
//@ use choice/media
//@ use choice/time
//@ use step/count
//@ relies on loops
// Light paths: emits, intersects, crosses media, scatters and connects to the lens, with several bounces per dispatch. They have the slots
// while no camera path does.
override WORKGROUP_SIZE: u32 = 64u;

// As of stage/bounce.
const MOST_ITERATIONS: u32 = 16384u;

@compute @workgroup_size(WORKGROUP_SIZE)
fn light_path(@builtin(global_invocation_id) id: vec3<u32>) {
    let slot = window.first_slot + id.x;
    if slot >= window.end_slot {
        return;
    }
    var path: Path;
    path.status = PATH_ENDED;
    if window.begins == 0u {
        load_path(slot, &path);
    }
    if path.status == SLOT_IDLE {
        return;
    }
    path.rays = 0u;
    path.light_paths = vec2<u32>(0u);
    path.light = NO_LIGHT;
    var iterations = MOST_STEPS_OF_MEDIA;
    for (var i = 0u; i < window.bounces && iterations < MOST_ITERATIONS; i++) {
        if path.status == PATH_ENDED && !start_light_path(&path) {
            break;
        }
        if path.status == PATH_ENDED {
            continue;
        }
        begin_time(&path);
        path.rays += 1u;
        iterations += trace(&path) + ITERATIONS_OF_SHADING;
        let is_first = path.depth == FIRST_LIGHT_EVENT;
        iterations = cross_media(&path, iterations);
        if path.status < FIRST_STATUS && is_within_depth(path.depth) {
            scatter_light_path(&path);
        } else if path.status != RAY_READY || is_first {
            // It has left the scene or has all events of max_depth, or its first event is not specular.
            end_light_path(&path);
        }
        iterations = trace_to_lens(&path, iterations);
        if path.status == PATH_CUT || all(path.throughput == vec3<f32>(0.0)) {
            end_light_path(&path);
        }
    }
    store_path(slot, &path);
    count(RAYS, path.rays);
    count(LIGHT_PATHS, path.light_paths.x);
    count(LIGHT_PATHS + 1u, path.light_paths.y);
}

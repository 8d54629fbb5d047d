//@ use data/path
//@ use bind/counters
//@ use bind/settings
//@ use scene/surfaces
//@ use step/density_ratio
//@ use step/scatter
//@ use step/trace
//@ use test/recorded_events
// A light path that has just sent its ray to the lens is followed back from there, as a camera path.

const TOLERANCE: f32 = ${tolerance};

fn count_path(sum: u32, is_counted: bool) {
    // The host reads these counters in units of 2^-24.
    atomicAdd(&counters.light[0][sum][0], select(0u, 1u, is_counted));
}

fn follow_back(light: ptr<function, Path>) {
    let is_recorded = all(recorded_path == vec2<u32>((*light).pixel, (*light).sample));
    if (*light).light != HIT_NOTHING || !is_recorded || !(log_ratio_at_lens < 0x1p90f) {
        return;
    }
    var path = *light;
    path.ray = Ray((*light).shadow.origin + (*light).lens_distance * (*light).shadow.direction, -(*light).shadow.direction);
    path.throughput = vec3<f32>(1.0);
    path.radiance = vec3<f32>(0.0);
    path.depth = 0u;
    path.pdf = 0.0;
    path.log_ratio = 0.0;
    path.light = NO_LIGHT;
    let events = recorded_events;
    events_to_follow = events;
    while events_to_follow > 0u {
        trace(&path);
        let event = recorded[events_to_follow - 1u];
        if path.status != event.code || distance(hit_point(&path), event.point) > 1e-4 {
            // Something is in the way of the ray to the lens.
            events_to_follow = 0u;
            atomicAdd(&counters.cut, 1u);
            return;
        }
        scatter_path(&path);
        if path.status != RAY_READY {
            events_to_follow = 0u;
            count_path(1u, true);
            return;
        }
    }
    trace(&path);
    if path.status != recorded_light {
        atomicAdd(&counters.cut, 1u);
        return;
    }
    let hit = path_hit(&path);
    let of_light_path = 1.0 / (1.0 + exp2(-log_ratio_at_lens));
    let of_camera_path = weigh_beside_light_paths(&path, hit, surface_at(hit, path.ray), 1.0);
    scatter_path(&path);
    // The light path's share of the pixel, for each sample that the pixel has.
    let shares = (*light).light_weight * (f32(RUN_LENGTH) / f32(settings.light_paths));
    let light_error = abs(shares / path.throughput - 1.0);
    let weight_error = abs(of_light_path + of_camera_path - 1.0);
    count_path(0u, true);
    count_path(1u, !(max(max(light_error.x, light_error.y), max(light_error.z, weight_error)) < TOLERANCE));
}

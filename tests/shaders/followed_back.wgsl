//@ use bind/counters
//@ use bind/settings
//@ use scene/surfaces
//@ use choice/delta_lights
//@ use medium/phase_pdf
//@ use light_path/density_ratio
//@ use step/light
//@ use step/scatter
//@ use step/trace
//@ use test/recorded_events
// A light path that has just sent its ray to the lens is followed back from there, as a camera path.

const TOLERANCE: f32 = ${tolerance};

fn count_path(sum: u32, is_counted: bool) {
    // The host reads these counters in units of 2^-24.
    atomicAdd(&counters.light[0][sum][0], select(0u, 1u, is_counted));
}

// That of all media of the test.
const ANISOTROPY: f32 = 0.5;

// The camera's order of an event in a medium.
fn follow_in_medium(path: ptr<function, Path>, event: RecordedEvent) {
    let direction = -event.incoming;
    (*path).pdf = phase_pdf((*path).ray.direction, direction, ANISOTROPY, 1.0 - ANISOTROPY);
    follow_ratio_in_medium(path, distance(event.point, (*path).ray.origin));
    (*path).ray = Ray(event.point, direction);
    (*path).throughput *= event.weight;
    (*path).depth += 1u;
    (*path).status = RAY_READY;
}

// Follows the recorded events. Returns whether nothing was in the way, and counts a path that is not scattered.
fn follow_events(path: ptr<function, Path>) -> bool {
    events_to_follow = recorded_events;
    while events_to_follow > 0u {
        let event = recorded[events_to_follow - 1u];
        trace(path);
        if event.code == IN_MEDIUM {
            if distance(event.point, (*path).ray.origin) > (*path).t {
                return false;
            }
            events_to_follow -= 1u;
            follow_in_medium(path, event);
            continue;
        }
        if (*path).status != event.code || distance(hit_point(path), event.point) > 1e-4 {
            return false;
        }
        // No shadow ray of an event before is traced.
        (*path).light = NO_LIGHT;
        scatter_path(path);
        if (*path).status != RAY_READY {
            count_path(0u, true);
            count_path(1u, true);
            return false;
        }
    }
    return true;
}

fn follow_back(light: ptr<function, Path>) {
    let is_recorded = all(recorded_path == vec2<u32>((*light).pixel, (*light).sample));
    if (*light).light != HIT_NOTHING || (*light).lens_distance == VERY_FAR || !is_recorded || !(log_ratio_at_lens < 0x1p90f) {
        return;
    }
    var path = *light;
    path.ray = Ray((*light).shadow.origin + (*light).lens_distance * (*light).shadow.direction, -(*light).shadow.direction);
    path.throughput = vec3<f32>(1.0);
    path.depth = 0u;
    path.pdf = 0.0;
    path.log_ratio = 0.0;
    path.light = NO_LIGHT;
    is_following = true;
    let is_free = follow_events(&path);
    is_following = false;
    events_to_follow = 0u;
    if !is_free {
        atomicAdd(&counters.cut, 1u);
        return;
    }
    let of_light_path = 1.0 / (1.0 + exp2(-log_ratio_at_lens));
    // The light path's share of the pixel, for each sample that the pixel has.
    let share = (*light).light_weight * (f32(RUN_LENGTH) / f32(settings.light_paths));
    var weight_error = 0.0;
    // The light by light sampling at the last event, unless that is specular. (A layer of one direction stands over a body that samples lights.)
    let has_sample = path.light != NO_LIGHT && recorded[0].lobe != LOBE_SPECULAR;
    var brought = path.light_weight;
    var factor = 1.0;
    if has_sample {
        let of_sample = weigh_sample_beside_light_paths(&path, limit_of_shadow(&path));
        weight_error = abs(of_light_path + of_sample - 1.0);
        brought *= of_sample;
    }
    // Then the light that BSDF sampling finds.
    if !is_delta_light(recorded_light) {
        path.light = NO_LIGHT;
        trace(&path);
        if path.status != recorded_light {
            atomicAdd(&counters.cut, 1u);
            return;
        }
        let hit = path_hit(&path);
        let power = mis_weight(&path, hit, surface_at(hit, path.ray).local);
        let of_bsdf = weigh_beside_light_paths(&path, hit, surface_at(hit, path.ray), power) / power;
        weight_error = max(weight_error, abs(of_light_path + of_bsdf - 1.0));
        // A surface that emits and scatters adds its light to the radiance.
        path.radiance = vec3<f32>(0.0);
        scatter_path(&path);
        path.light = NO_LIGHT;
        brought = select(path.radiance, path.throughput, all(path.radiance == vec3<f32>(0.0)));
        // The balance of both techniques of camera paths, over the power heuristic.
        factor = power * (1.0 + sqrt(1.0 / power - 1.0));
    } else if !has_sample {
        return;
    }
    let light_error = abs(share / brought * factor - 1.0);
    count_path(0u, true);
    count_path(1u, !(max(max(light_error.x, light_error.y), max(light_error.z, weight_error)) < TOLERANCE));
}

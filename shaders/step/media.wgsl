//@ implements media when medium
//@ use bind/settings
//@ use choice/sampler
//@ use scene/at_run_time
//@ use medium/phase
//@ use step/flight
//@ use choice/density_ratio
//@ use choice/depth_limit
//@ use choice/light_absorption
//@ use choice/medium_albedo
//@ use choice/roulette
//@ use choice/medium_emission
//@ use choice/medium_light
//@ use choice/aov_surface
// Lets media scatter the path before it reaches its hit.

// The most loop iterations: one per medium, and the steps of the walks through meshes.
const MOST_STEPS_OF_MEDIA: u32 = MEDIA + STEPS_OF_CROSSINGS;

// Scatters the path at the first event of its free flight, if there is one. Returns `iterations` plus its own.
fn cross_media(path: ptr<function, Path>, iterations: u32) -> u32 {
    if (*path).status == PATH_CUT {
        return iterations;
    }
    let nearest = nearest_collision(path, (*path).t);
    let total = iterations + nearest.steps;
    if nearest.t == WALK_CUT {
        (*path).status = PATH_CUT;
        return total;
    }
    if nearest.medium == NO_MEDIUM {
        return total;
    }
    absorb_ray(path, nearest.t);
    let ray = (*path).ray;
    let depth = (*path).depth;
    let medium = media[at_run_time(nearest.medium)];
    let point = ray.origin + nearest.t * ray.direction;
    let albedo = medium_albedo(medium, point);
    let throughput = (*path).throughput * albedo;
    record_medium(path, throughput);
    add_medium_emission(path, nearest.medium, medium, point, albedo);
    if is_within_depth(depth) && any(throughput != vec3<f32>(0.0)) {
        let u = random4((*path).pixel, (*path).sample, bounce_dimension(depth, DIMENSION_SCATTER), settings.seed);
        let direction = sample_phase(ray.direction, medium.anisotropy, medium.one_minus_anisotropy, u.xy);
        sample_light_in_medium(path, medium, point, direction);
        follow_ratio_in_medium(path, nearest.t);
        (*path).ray = Ray(point, direction);
        (*path).status = RAY_READY;
        (*path).throughput = russian_roulette(path, throughput);
        (*path).depth = depth + 1u;
        if all((*path).throughput == vec3<f32>(0.0)) {
            (*path).status = PATH_ENDED;
        }
    } else {
        (*path).status = select(PATH_ENDED, PATH_TOO_DEEP, any(throughput != vec3<f32>(0.0)));
        (*path).throughput = throughput;
    }
    return total;
}

//@ without
// No medium scatters paths.
const MOST_STEPS_OF_MEDIA: u32 = 0u;

fn cross_media(path: ptr<function, Path>, iterations: u32) -> u32 {
    return iterations;
}

//@ use data/path
//@ use data/dimension
//@ use data/medium
//@ use data/primitive
//@ use bind/settings
//@ use choice/sampler
//@ use scene/at_run_time
//@ use lib/rng
//@ use medium/free_flight
//@ use medium/phase
//@ use scene/media
//@ use choice/medium_albedo
//@ use choice/roulette
//@ use choice/medium_light
//@ use choice/aov_surface
// Lets media scatter the path before it reaches its hit.

const MEDIA: u32 = ${media}u;
// The most loop iterations: one per medium, and the steps of the walks through meshes.
const MOST_STEPS_OF_MEDIA: u32 = MEDIA + STEPS_OF_CROSSINGS;

// The first medium uses the sampler's own words, which may be stratified. Each other medium uses a hash of them.
fn words_of_medium(words: vec4<u32>, medium: u32) -> vec2<u32> {
    return select(pcg4d(words + medium), words, medium == 0u).xy;
}

// Each medium samples the optical depth of its own scattering event, and the nearest event is the path's. Where media overlap,
// their densities add up: the first event of independent Poisson processes is an event of the process with the sum of their
// rates, and it belongs to each process with a probability proportional to its rate. Returns
// `iterations` plus its own.
fn cross_media(path: ptr<function, Path>, iterations: u32) -> u32 {
    if (*path).status == PATH_CUT {
        return iterations;
    }
    let ray = (*path).ray;
    let depth = (*path).depth;
    let words = random_words((*path).pixel, (*path).sample, bounce_dimension(depth, DIMENSION_MEDIUM), settings.seed);
    var nearest = (*path).t;
    var scatterer = NO_MEDIUM;
    var steps = 0u;
    for (var i = 0u; i < MEDIA; i++) {
        let depth = optical_depth(words_of_medium(words, i));
        let t = collision(media[at_run_time(i)], ray, depth, nearest, &steps);
        if t == WALK_CUT {
            (*path).status = PATH_CUT;
            return iterations + MEDIA + steps;
        }
        if t != NO_HIT {
            nearest = t;
            scatterer = i;
        }
    }
    if scatterer == NO_MEDIUM {
        return iterations + MEDIA + steps;
    }
    let medium = media[at_run_time(scatterer)];
    let point = ray.origin + nearest * ray.direction;
    let throughput = (*path).throughput * medium_albedo(medium, point);
    record_medium(path, throughput);
    if depth < settings.max_depth && any(throughput != vec3<f32>(0.0)) {
        let u = random4((*path).pixel, (*path).sample, bounce_dimension(depth, DIMENSION_SCATTER), settings.seed);
        let direction = sample_phase(ray.direction, medium.anisotropy, medium.one_minus_anisotropy, u.xy);
        sample_light_in_medium(path, medium, point, direction);
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
    return iterations + MEDIA + steps;
}

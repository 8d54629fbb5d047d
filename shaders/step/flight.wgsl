//@ use bind/settings
//@ use choice/sampler
//@ use choice/collision
// The free flight of a path through the media on its ray.

const MEDIA: u32 = ${media}u;

// The end of a flight.
struct Collision {
    // The distance, or WALK_CUT if a walk took too many steps.
    t: f32,
    // The medium that scatters, or NO_MEDIUM.
    medium: u32,
    // The loop iterations.
    steps: u32,
}

// The first medium uses the sampler's own words, which may be stratified. Each other medium uses a hash of them.
fn words_of_medium(words: vec4<u32>, medium: u32) -> vec4<u32> {
    return select(pcg4d(words + medium), words, medium == 0u);
}

// Each medium samples the optical depth of its own scattering event, and the nearest event is the path's. Where media overlap,
// their densities add up: the first event of independent Poisson processes is an event of the process with the sum of their
// rates, and it belongs to each process with a probability proportional to its rate. Events beyond `limit` do not count.
fn nearest_collision(path: ptr<function, Path>, limit: f32) -> Collision {
    let ray = (*path).ray;
    let dimension = bounce_dimension((*path).depth, DIMENSION_MEDIUM);
    let words = random_words((*path).pixel, (*path).sample, dimension, settings.seed);
    var nearest = Collision(limit, NO_MEDIUM, 0u);
    var steps = MEDIA;
    for (var i = 0u; i < MEDIA; i++) {
        let t = collision(i, ray, words_of_medium(words, i), nearest.t, &steps);
        if t == WALK_CUT {
            return Collision(WALK_CUT, NO_MEDIUM, steps);
        }
        if t != NO_HIT {
            nearest.t = t;
            nearest.medium = i;
        }
    }
    nearest.steps = steps;
    return nearest;
}

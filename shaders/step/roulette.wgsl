//@ use data/path
//@ use data/dimension
//@ use bind/settings
//@ use choice/sampler
// Russian roulette (Arvo and Kirk, "Particle Transport and Image Synthesis", SIGGRAPH 1990): a path whose throughput has become
// small goes on with a probability, and is worth more by as much if it does. The expectation stays.

// Events before the first that can end a path: near the camera a path is cheap and its light bright.
const ROULETTE_AFTER: u32 = 2u;
// A path goes on for sure while its throughput is above one over this. Measured: at 1 the error at equal cost grows under
// bright skies, from 5 on it falls everywhere.
const ROULETTE_CARE: f32 = 6.0;
// No path is worth more than this many times what it was.
const ROULETTE_LEAST: f32 = 0.05;

// The throughput that the path goes on with after an event, or zero.
fn russian_roulette(path: ptr<function, Path>, throughput: vec3<f32>) -> vec3<f32> {
    let depth = (*path).depth;
    let q = max(ROULETTE_CARE * max(max(throughput.x, throughput.y), throughput.z), ROULETTE_LEAST);
    if depth < ROULETTE_AFTER || q >= 1.0 {
        return throughput;
    }
    let u = random4((*path).pixel, (*path).sample, bounce_dimension(depth, DIMENSION_ROULETTE), settings.seed);
    return select(vec3<f32>(0.0), throughput / q, u.x < q);
}

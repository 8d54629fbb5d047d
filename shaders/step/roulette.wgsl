//@ alternative roulette when roulette.on
//@ use bind/settings
//@ use choice/sampler
// Russian roulette (Arvo and Kirk, "Particle Transport and Image Synthesis", SIGGRAPH 1990): a path of small throughput
// continues with a probability q, and its throughput is divided by q. The expectation does not change.

// The first depth at which a path can end. Near the camera, paths are cheap and their light is bright.
const ROULETTE_AFTER: u32 = 2u;
// A path always continues if the largest component of its throughput is at least 1 over this. Measured: at 1, the error at
// equal cost grows under bright skies; from 5 on, it falls in every scene.
const ROULETTE_CARE: f32 = 6.0;
// The smallest q. Roulette multiplies a throughput by at most 1 over this.
const ROULETTE_LEAST: f32 = 0.05;

// The throughput after roulette. Zero ends the path.
fn russian_roulette(path: ptr<function, Path>, throughput: vec3<f32>) -> vec3<f32> {
    let depth = (*path).depth;
    let q = max(ROULETTE_CARE * max(max(throughput.x, throughput.y), throughput.z), ROULETTE_LEAST);
    if depth < ROULETTE_AFTER || q >= 1.0 {
        return throughput;
    }
    let u = random4((*path).pixel, (*path).sample, bounce_dimension(depth, DIMENSION_ROULETTE), settings.seed);
    return select(vec3<f32>(0.0), throughput / q, u.x < q);
}

//@ without
// Without Russian roulette, every path continues.
fn russian_roulette(path: ptr<function, Path>, throughput: vec3<f32>) -> vec3<f32> {
    return throughput;
}

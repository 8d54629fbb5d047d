//@ use bind/settings
//@ use choice/sampler
// Wrong on purpose: paths that survive are worth no more than before.
fn russian_roulette(path: ptr<function, Path>, throughput: vec3<f32>) -> vec3<f32> {
    let depth = (*path).depth;
    let q = max(6.0 * max(max(throughput.x, throughput.y), throughput.z), 0.05);
    if depth < 2u || q >= 1.0 {
        return throughput;
    }
    let u = random4((*path).pixel, (*path).sample, bounce_dimension(depth, DIMENSION_ROULETTE), settings.seed);
    return select(vec3<f32>(0.0), throughput, u.x < q);
}

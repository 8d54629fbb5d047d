//@ use data/path
//@ use data/dimension
//@ use bind/settings
//@ use choice/filter
//@ use choice/sampler
// The weights of a filter with negative lobes.

// A value of the path's sample with its weight. The sample's point is drawn again: its numbers are the same.
fn weigh_by_filter(path: ptr<function, Path>, value: vec3<f32>) -> vec3<f32> {
    let u = random4((*path).pixel, (*path).sample, DIMENSION_CAMERA, settings.seed);
    return value * filter_weight(u.xy);
}

// The sums of such values have either sign.
fn unsigned_sum(sum: vec3<f32>) -> vec3<f32> {
    return abs(sum);
}

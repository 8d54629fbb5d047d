//@ implements filter_weight when filter.mitchell
//@ use bind/settings
//@ use choice/filter
//@ use choice/sampler
// The weights of a filter with negative lobes.

// Returns a value of the path's sample times the sample's filter weight. The same random numbers give its film point again.
fn weigh_by_filter(path: ptr<function, Path>, value: vec3<f32>) -> vec3<f32> {
    let u = random4((*path).pixel, (*path).sample, DIMENSION_CAMERA, settings.seed);
    return value * filter_weight(u.xy);
}

// Weighted sums may be negative, and only their NaNs are refused.
fn unsigned_sum(sum: vec3<f32>) -> vec3<f32> {
    return abs(sum);
}

//@ without
// All samples of the filter have the weight 1.
fn weigh_by_filter(path: ptr<function, Path>, value: vec3<f32>) -> vec3<f32> {
    return value;
}

fn unsigned_sum(sum: vec3<f32>) -> vec3<f32> {
    return sum;
}

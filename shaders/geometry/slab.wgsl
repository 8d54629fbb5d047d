// The slab test against boxes (Kay and Kajiya 1986), guarded against components of the direction that are 0.

// 1/d, with |d| at least 2^-64, so that neither the reciprocal nor its product with a zero is a NaN.
fn slab_inverse(direction: vec3<f32>) -> vec3<f32> {
    let tiny = vec3<f32>(0x1p-64f);
    let guarded = select(-tiny, tiny, direction >= vec3<f32>(0.0));
    return 1.0 / select(direction, guarded, abs(direction) < tiny);
}

// The distances at which a ray enters and leaves the slab of each axis. The ray misses the box if the last entry
// is farther than the first exit.
struct Slab {
    enter: vec3<f32>,
    leave: vec3<f32>,
}

fn slab(origin: vec3<f32>, inverse: vec3<f32>, low: vec3<f32>, high: vec3<f32>) -> Slab {
    let t0 = (low - origin) * inverse;
    let t1 = (high - origin) * inverse;
    return Slab(min(t0, t1), max(t0, t1));
}

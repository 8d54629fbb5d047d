//@ use geometry/slab
// Whether a ray may meet what a BVH box holds, nearer than `nearest`; never a false no.

const BOX_MISSED: f32 = 0x1p127f;

// The distance of entry, 0 from inside, or BOX_MISSED. Leaving is moved out by two ulps times gamma(3)
// (Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013); 3 ulps of division are allowed for by WGSL instead of half of one.
fn box_entry(origin: vec3<f32>, inverse: vec3<f32>, low: vec3<f32>, high: vec3<f32>, nearest: f32) -> f32 {
    let s = slab(origin, inverse, low, high);
    let enter = max(max(s.enter.x, s.enter.y), max(s.enter.z, 0.0));
    let leave = min(min(s.leave.x, s.leave.y), s.leave.z) * 1.000001;
    return select(BOX_MISSED, enter, enter <= min(leave, nearest));
}

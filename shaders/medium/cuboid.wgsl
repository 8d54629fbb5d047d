//@ use data/ray
//@ use data/primitive
//@ use geometry/cuboid
fn cuboid_interval(ray: Ray, cuboid: Cuboid) -> vec2<f32> {
    let s = cuboid_slab(ray, cuboid);
    let enter = max(max(s.enter.x, s.enter.y), s.enter.z);
    let leave = min(min(s.leave.x, s.leave.y), s.leave.z);
    return vec2<f32>(max(enter, 0.0), leave);
}

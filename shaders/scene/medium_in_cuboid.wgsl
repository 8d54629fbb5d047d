//@ use data/ray
//@ use data/hit
//@ use bind/cuboids
//@ use medium/cuboid
// The distance along a ray at which its way inside the cuboid has a length, if that is nearer than `limit`; else NO_HIT.
fn collision_in_cuboid(ray: Ray, index: u32, way: f32, limit: f32, steps: ptr<function, u32>) -> f32 {
    let inside = cuboid_interval(ray, cuboids[index]);
    let t = inside.x + way;
    return select(NO_HIT, t, t < min(inside.y, limit));
}

//@ each light
// The length of the way inside up to distance t.
fn way_in_cuboid(ray: Ray, index: u32, t: f32, steps: ptr<function, u32>) -> f32 {
    let inside = cuboid_interval(ray, cuboids[index]);
    return max(min(inside.y, t) - inside.x, 0.0);
}
//@ end

//@ use geometry/cuboid
//@ use medium/interval
// The interval of a ray inside a cuboid, exactly between the distances at which the ray hits the cuboid as a surface. So a
// medium that fills a block of glass ends where the glass ends, to the bit.
fn cuboid_interval(ray: Ray, cuboid: Cuboid) -> vec2<f32> {
    return interval_ahead(cuboid_crossings(cuboid_slab(ray, cuboid)));
}

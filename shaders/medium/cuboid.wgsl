//@ use data/ray
//@ use data/primitive
//@ use geometry/cuboid
//@ use medium/interval
// Where a ray is within a cuboid: between the very distances at which it meets the cuboid as a surface, so that a medium
// that fills a block of glass ends where the glass does, to the bit.
fn cuboid_interval(ray: Ray, cuboid: Cuboid) -> vec2<f32> {
    return interval_ahead(cuboid_crossings(cuboid_slab(ray, cuboid)));
}

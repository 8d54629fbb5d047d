//@ use data/ray
//@ use data/primitive
//@ use geometry/sphere
//@ use medium/interval
// Where a ray is within a sphere: between the very distances at which it meets the sphere as a surface, so that a medium
// that fills a sphere of glass ends where the glass does, to the bit.
fn sphere_interval(ray: Ray, sphere: Sphere) -> vec2<f32> {
    return interval_ahead(sphere_crossings(ray, sphere));
}

//@ use geometry/sphere
//@ use medium/interval
// The interval of a ray inside a sphere, exactly between the distances at which the ray hits the sphere as a surface. So a
// medium that fills a sphere of glass ends where the glass ends, to the bit.
fn sphere_interval(ray: Ray, sphere: Sphere) -> vec2<f32> {
    return interval_ahead(sphere_crossings(ray, sphere));
}

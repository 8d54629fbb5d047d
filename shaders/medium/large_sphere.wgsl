//@ use geometry/large_sphere
//@ use medium/interval
// The interval of a ray inside a large sphere, exactly between the distances at which the ray hits the large sphere as a surface. So a
// medium that fills a large sphere of glass ends where the glass ends, to the bit.
fn large_sphere_interval(ray: Ray, large_sphere: LargeSphere) -> vec2<f32> {
    return interval_ahead(large_sphere_crossings(ray, large_sphere));
}

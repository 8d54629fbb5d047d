//@ use data/ray
//@ use data/primitive
//@ use geometry/globe
//@ use medium/interval
// The interval of a ray inside a globe, exactly between the distances at which the ray hits the globe as a surface. So a
// medium that fills a globe of glass ends where the glass ends, to the bit.
fn globe_interval(ray: Ray, globe: Globe) -> vec2<f32> {
    return interval_ahead(globe_crossings(ray, globe));
}

//@ use data/ray
//@ use data/primitive
//@ use geometry/sphere
fn sphere_interval(ray: Ray, sphere: Sphere) -> vec2<f32> {
    return vec2<f32>(0.0, sphere_distance(ray, sphere));
}

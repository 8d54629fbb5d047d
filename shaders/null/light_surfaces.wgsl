//@ use data/hit
//@ use data/ray
// No surface is sampled as a light.
fn limit_at_surface(code: u32, instance: u32, shadow: Ray) -> Hit {
    return hit_at(code, 0.0);
}

fn emitted_by_surface(ray: Ray, hit: Hit) -> vec3<f32> {
    return vec3<f32>(0.0);
}

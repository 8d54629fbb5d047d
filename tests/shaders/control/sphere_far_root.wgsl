// Wrong on purpose: both roots as sums, so that the one near zero cancels.
fn sphere_crossings(ray: Ray, sphere: Sphere) -> vec2<f32> {
    let f = ray.origin - sphere.center;
    let dd = dot(ray.direction, ray.direction);
    let k = -dot(f, ray.direction) / dd;
    let c = dot(f, f) - sphere.radius * sphere.radius;
    let discriminant = k * k - c / dd;
    if !(discriminant >= 0.0) {
        return vec2<f32>(NO_HIT);
    }
    let h = sqrt(discriminant);
    return vec2<f32>(k - h, k + h);
}

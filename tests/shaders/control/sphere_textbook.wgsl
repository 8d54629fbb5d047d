// Wrong on purpose: the discriminant as b^2 - a c, which cancels where the sphere is far away.
fn sphere_distance(ray: Ray, sphere: Sphere) -> f32 {
    let f = ray.origin - sphere.center;
    let a = dot(ray.direction, ray.direction);
    let b = -dot(f, ray.direction);
    let c = dot(f, f) - sphere.radius * sphere.radius;
    let discriminant = b * b - a * c;
    if !(discriminant >= 0.0) {
        return NO_HIT;
    }
    let h = sqrt(discriminant);
    let first = (b - h) / a;
    let second = (b + h) / a;
    return select(select(NO_HIT, second, second > 0.0), first, first > 0.0);
}

fn sphere_surface(ray: Ray, t: f32, sphere: Sphere) -> Surface {
    return Surface();
}

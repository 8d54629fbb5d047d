//@ alternative sphere_chord when precision.fast & ball
// Where a ray's line crosses a sphere, by the quadratic formula of the textbooks (`--precision fast`; Shirley, Black, Hollasch, "Ray
// Tracing in One Weekend", sections 5.1 and 6.2), for directions of unit length. b^2 - c suffers cancellation: at the distance D, hits
// and misses are confused within u (D/r)^2 radii of the outline, where u = 2^-24. That is a hundredth of a radius from 400 radii on.

// The distances at which the ray's line crosses the sphere, the smaller first; NO_HIT twice if it misses.
fn sphere_crossings(ray: Ray, sphere: Sphere) -> vec2<f32> {
    let f = ray.origin - sphere.center;
    let b = dot(f, ray.direction);
    let discriminant = b * b - (dot(f, f) - sphere.radius * sphere.radius);
    if !(discriminant >= 0.0) {
        return vec2<f32>(NO_HIT);
    }
    let h = sqrt(discriminant);
    return vec2<f32>(-b - h, h - b);
}

// Unit normal where the ray hits the sphere at t: the direction from the centre to the point at t. Its error is the
// rounding of t over the radius.
fn sphere_normal(ray: Ray, t: f32, sphere: Sphere) -> vec3<f32> {
    return normalize(ray.origin + t * ray.direction - sphere.center);
}

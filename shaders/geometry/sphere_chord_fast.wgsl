//@ use data/ray
//@ use data/primitive
//@ use data/surface
// Where a ray's line cuts a sphere, by the quadratic formula as textbooks have it (`--precision fast`; Shirley, Black, Hollasch, "Ray
// Tracing in One Weekend", sections 5.1 and 6.2), for directions of unit length. b^2 - c cancels: with D the distance, decisions
// between hit and miss are wrong within u (D/r)^2 radii of the edge, u = 2^-24: a hundredth of a radius from 400 radii on.

// Distances at which the ray's line meets the sphere, the smaller first, or twice NO_HIT.
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

// Unit normal where the ray meets the sphere at t: the direction of the point there, off by the rounding of t over the radius.
fn sphere_normal(ray: Ray, t: f32, sphere: Sphere) -> vec3<f32> {
    return normalize(ray.origin + t * ray.direction - sphere.center);
}

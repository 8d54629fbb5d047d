//@ use data/ray
//@ use data/primitive
//@ use data/surface
// Where a ray's line cuts a sphere, right also where the sphere is small and far away.

// Where a ray's line comes nearest to the centre of a sphere.
struct SphereFoot {
    // From the centre.
    perpendicular: vec3<f32>,
    // Distance along the ray.
    k: f32,
    // The square of half the chord, in lengths of the direction; negative where the line misses the sphere.
    discriminant: f32,
}

// The discriminant is (r + l)(r - l) with l the length of the perpendicular from the centre to the ray, which keeps its
// digits where b^2 - ac has none (Haines, Günther, Akenine-Möller, "Precision Improvements for Ray/Sphere Intersection", Ray Tracing
// Gems, ch. 7). What rounding has left of the ray's direction in the perpendicular, up to 8 u D, is taken out by the same step
// again (own derivation: "twice is enough", Parlett, The Symmetric Eigenvalue Problem, section 6.9): it would count by its square,
// which is the sphere's own size from D = 1e6 r on.
fn sphere_foot(ray: Ray, sphere: Sphere) -> SphereFoot {
    let d = ray.direction;
    let f = ray.origin - sphere.center;
    let inverse = 1.0 / dot(d, d);
    let k = -dot(f, d) * inverse;
    let rough = f + k * d;
    let rest = -dot(rough, d) * inverse;
    let perpendicular = rough + rest * d;
    let l = length(perpendicular);
    return SphereFoot(perpendicular, k + rest, (sphere.radius + l) * (sphere.radius - l) * inverse);
}

// Distances at which the ray's line meets the sphere, the smaller first, or twice NO_HIT. A tangent from where it touches
// gives no numbers, which fail every comparison. The root that would cancel is found from the product of the roots.
fn sphere_crossings(ray: Ray, sphere: Sphere) -> vec2<f32> {
    let foot = sphere_foot(ray, sphere);
    if !(foot.discriminant >= 0.0) {
        return vec2<f32>(NO_HIT);
    }
    let h = sqrt(foot.discriminant);
    let far_from_zero = foot.k + select(-h, h, foot.k >= 0.0);
    let d = ray.direction;
    let length_f = length(ray.origin - sphere.center);
    let product = (length_f - sphere.radius) * (length_f + sphere.radius) / dot(d, d);
    let near_to_zero = product / far_from_zero;
    return vec2<f32>(min(far_from_zero, near_to_zero), max(far_from_zero, near_to_zero));
}

// Unit normal where the ray meets the sphere at t. It is the perpendicular and half a chord, not the point at t: that one is off by the
// rounding of t, which of a small sphere far away is as large as the sphere.
fn sphere_normal(ray: Ray, t: f32, sphere: Sphere) -> vec3<f32> {
    let foot = sphere_foot(ray, sphere);
    let h = sqrt(max(foot.discriminant, 0.0));
    // From inside the far end of the chord is met, from outside the near one: as their product tells sphere_crossings.
    let along = select(-h, h, length(ray.origin - sphere.center) < sphere.radius);
    return normalize(foot.perpendicular + along * ray.direction);
}

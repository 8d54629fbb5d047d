//@ alternative sphere_chord when !(precision.fast & ball)
// Where a ray's line crosses a sphere, accurate even if the sphere is small and far away.

// The point of a ray's line that is nearest to the centre of a sphere.
struct SphereFoot {
    // The vector from the centre to that point.
    perpendicular: vec3<f32>,
    // The distance to that point along the ray.
    k: f32,
    // The square of half the chord, measured in units of the direction's length. Negative if the line misses the sphere.
    discriminant: f32,
}

// The discriminant is (r + l)(r - l), with l the length of the perpendicular from the centre to the ray. It keeps its precision
// where b^2 - ac has none (Haines, Günther, Akenine-Möller, "Precision Improvements for Ray/Sphere Intersection", Ray Tracing
// Gems, ch. 7). At the distance D, the computed perpendicular has an error of up to 8 u D along the ray. A second projection
// removes it (own derivation: "twice is enough", Parlett, The Symmetric Eigenvalue Problem, section 6.9). Without that, the
// square of this error would be part of l^2, and from D = 1e6 r on it is as large as r^2.
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

// The distances at which the ray's line crosses the sphere, the smaller first; NO_HIT twice if it misses. A tangent ray
// that starts at its point of contact gives NaN or 0, which is no hit. One root would suffer cancellation; it is computed from
// the product of both. Rounding can make the product too large, where a ray leaves the sphere and only touches it. So the root is
// clamped: it is the nearer one to zero.
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
    let near_to_zero = clamp(product / far_from_zero, -abs(far_from_zero), abs(far_from_zero));
    return vec2<f32>(min(far_from_zero, near_to_zero), max(far_from_zero, near_to_zero));
}

// Unit normal where the ray hits the sphere at t, computed from the perpendicular and half the chord. The point at t would not
// do: it is off by the rounding of t, which is as large as the sphere if the sphere is small and far away.
fn sphere_normal(ray: Ray, t: f32, sphere: Sphere) -> vec3<f32> {
    let foot = sphere_foot(ray, sphere);
    let h = sqrt(max(foot.discriminant, 0.0));
    // From inside, the ray hits the far end of the chord, and from outside the near end. This is the same decision as in
    // sphere_crossings, by the sign of the product of the roots.
    let along = select(-h, h, length(ray.origin - sphere.center) < sphere.radius);
    return normalize(foot.perpendicular + along * ray.direction);
}

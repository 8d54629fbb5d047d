//@ use data/ray
//@ use data/primitive
//@ use data/hit
//@ use lib/float
//@ use lib/sphere_map

// Distances at which the ray's line meets the sphere, the smaller first, or twice NO_HIT. A tangent from where it touches
// gives no numbers, which fail every comparison.
// The discriminant is (r + l)(r - l) with l the length of the perpendicular from the centre to the ray, which keeps its
// digits where b^2 - ac has none; the root that would cancel is found from the product of the roots
// (Haines, Günther, Akenine-Möller, "Precision Improvements for Ray/Sphere Intersection", Ray Tracing Gems, ch. 7).
fn sphere_crossings(ray: Ray, sphere: Sphere) -> vec2<f32> {
    let f = ray.origin - sphere.center;
    let dd = dot(ray.direction, ray.direction);
    let k = -dot(f, ray.direction) / dd;
    let perpendicular = f + k * ray.direction;
    let l = length(perpendicular);
    let discriminant = (sphere.radius + l) * (sphere.radius - l);
    if !(discriminant >= 0.0) {
        return vec2<f32>(NO_HIT);
    }
    let h = sqrt(discriminant / dd);
    let far_from_zero = k + select(-h, h, k >= 0.0);
    let length_f = length(f);
    let product = (length_f - sphere.radius) * (length_f + sphere.radius) / dd;
    let near_to_zero = product / far_from_zero;
    return vec2<f32>(min(far_from_zero, near_to_zero), max(far_from_zero, near_to_zero));
}

// Distance to the sphere's nearest point in front of the origin, or NO_HIT.
fn sphere_distance(ray: Ray, sphere: Sphere) -> f32 {
    let t = sphere_crossings(ray, sphere);
    return select(select(NO_HIT, t.y, t.y > 0.0), t.x, t.x > 0.0);
}

// The point is put back onto the sphere along its normal, which leaves only the rounding of centre + r n. The normal is found
// from the foot of the perpendicular and half the chord, and not from o + t d: t is off by u times the distance, which far
// away is the sphere's own size. What the foot has along the ray is the error of k; it is taken out again.
fn sphere_surface(ray: Ray, t: f32, sphere: Sphere) -> Surface {
    let f = ray.origin - sphere.center;
    let dd = dot(ray.direction, ray.direction);
    let foot = f - (dot(f, ray.direction) / dd) * ray.direction;
    let perpendicular = foot - (dot(foot, ray.direction) / dd) * ray.direction;
    let l = length(perpendicular);
    let h = sqrt(max((sphere.radius + l) * (sphere.radius - l), 0.0) / dd);
    // From inside the far end of the chord is met, from outside the near one: as their product tells sphere_crossings.
    let along = select(-h, h, length(f) < sphere.radius);
    let normal = normalize(perpendicular + along * ray.direction);
    var surface: Surface;
    surface.point = sphere.center + sphere.radius * normal;
    surface.normal = normal;
    let c = abs(sphere.center);
    surface.error = 4.0 * UNIT_ROUNDOFF * (max(max(c.x, c.y), c.z) + sphere.radius);
    surface.material = sphere.material;
    surface.frame = sphere.frame;
    surface.local = normal;
    return surface;
}

// `point` is the unit normal in the object's space.
fn sphere_uv(point: vec3<f32>, local: vec3<f32>) -> SurfaceUv {
    return SurfaceUv(sphere_uv_at(point), true);
}

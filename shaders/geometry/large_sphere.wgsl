// A sphere given by its point nearest to the camera, the normal there and the curvature c = 1/r (own derivation). Points x are
// relative to that point, and n is the inward normal there. Errors are then relative to |x|, not to the radius.

// The power of a point, over the radius: c x² - 2 n.x = (D² - r²) / r, with D the distance from the centre. It is twice the height
// above the sphere if that is small. It is negative inside.
fn large_sphere_power(large_sphere: LargeSphere, x: vec3<f32>) -> f32 {
    return large_sphere.curvature * dot(x, x) - 2.0 * dot(large_sphere.inward, x);
}

// The vector from the centre to a point, in radii.
fn large_sphere_upward(large_sphere: LargeSphere, x: vec3<f32>) -> vec3<f32> {
    return large_sphere.curvature * x - large_sphere.inward;
}

// A ray's line as the large sphere has it. The line crosses it at the distances t with c t² + 2 slope t + power = 0.
struct LargeSphereLine {
    // The ray's origin.
    x: vec3<f32>,
    slope: f32,
    // The vector from the centre to the point of the line that is nearest to it, in radii.
    perpendicular: vec3<f32>,
    power: f32,
    // The square of half the chord, in radii. Negative if the line misses the large sphere.
    discriminant: f32,
    // Whether the origin is more than a radius away.
    far: bool,
}

// The discriminant slope² - c power has an error of some u D²/r². From far away, it is computed from the perpendicular instead, as for
// other spheres (geometry/sphere_chord), whose error from near is u and would be larger than the square of a small slope.
fn large_sphere_line(ray: Ray, large_sphere: LargeSphere) -> LargeSphereLine {
    let x = ray.origin - large_sphere.nearest;
    let upward = large_sphere_upward(large_sphere, x);
    let slope = dot(upward, ray.direction);
    let power = large_sphere_power(large_sphere, x);
    let rough = upward - slope * ray.direction;
    let perpendicular = rough - dot(rough, ray.direction) * ray.direction;
    let l = length(perpendicular);
    let far = dot(upward, upward) > 4.0;
    let discriminant = select(slope * slope - large_sphere.curvature * power, (1.0 + l) * (1.0 - l), far);
    return LargeSphereLine(x, slope, perpendicular, power, discriminant, far);
}

// The distances at which the ray's line crosses the large sphere, the smaller first; NO_HIT twice if it misses. A tangent ray
// that starts at its point of contact gives NaN or 0, which is no hit. One root would suffer cancellation; it is computed from
// the product of both, and clamped (geometry/sphere_chord).
fn large_sphere_crossings(ray: Ray, large_sphere: LargeSphere) -> vec2<f32> {
    let line = large_sphere_line(ray, large_sphere);
    if !(line.discriminant >= 0.0) {
        return vec2<f32>(NO_HIT);
    }
    let h = sqrt(line.discriminant);
    let q = select(-h, h, line.slope <= 0.0) - line.slope;
    let far_from_zero = q / large_sphere.curvature;
    let near_to_zero = clamp(line.power / q, -abs(far_from_zero), abs(far_from_zero));
    return vec2<f32>(min(far_from_zero, near_to_zero), max(far_from_zero, near_to_zero));
}

// Distance to the nearest crossing of the large sphere in front of the ray's origin, or NO_HIT.
fn large_sphere_distance(ray: Ray, large_sphere: LargeSphere) -> f32 {
    let t = large_sphere_crossings(ray, large_sphere);
    return select(select(NO_HIT, t.y, t.y > 0.0), t.x, t.x > 0.0);
}

// Bound of the rounding error of a point along the normal, plus the error of the next power that is computed from the point. In
// units of roundoff:
// - A power is off by 4 c x² + 6 |n|.|x|, and a height by half of this. It is computed twice: here, and for the next ray.
// - The point is rounded by |normal|.|x|, and twice more where `nearest` is added and subtracted again: |normal|.(|nearest| + 2 |x|).
// - Before it is moved onto the large sphere by `offset`, the point is `offset` farther off: up to 16 |offset|.
fn large_sphere_error(large_sphere: LargeSphere, x: vec3<f32>, normal: vec3<f32>, offset: f32) -> f32 {
    let sum = abs(large_sphere.nearest) + 3.0 * abs(x);
    let of_power = 6.0 * dot(abs(large_sphere.inward), abs(x)) + 4.0 * large_sphere.curvature * dot(x, x);
    return UNIT_ROUNDOFF * (dot(abs(normal), sum) + of_power + 16.0 * abs(offset));
}

// The point at t is moved onto the large sphere along the normal. If the ray comes from far away, the point at t is off by the rounding
// of t, which can be larger than the large sphere; then it is computed from the perpendicular and half the chord.
fn large_sphere_surface(ray: Ray, t: f32, large_sphere: LargeSphere) -> Surface {
    let line = large_sphere_line(ray, large_sphere);
    let outward = normalize(line.perpendicular - sqrt(max(line.discriminant, 0.0)) * ray.direction);
    let from_far = (outward + large_sphere.inward) / large_sphere.curvature;
    let rough = select(line.x + t * ray.direction, from_far, line.far);
    let upward = large_sphere_upward(large_sphere, rough);
    let radii = length(upward);
    let normal = upward / radii;
    // D - r = (D² - r²) / (D + r).
    let offset = large_sphere_power(large_sphere, rough) / (1.0 + radii);
    let x = rough - offset * normal;
    var surface: Surface;
    surface.point = large_sphere.nearest + x;
    surface.normal = normal;
    surface.error = large_sphere_error(large_sphere, x, normal, offset);
    surface.material = large_sphere.material;
    surface.frame = large_sphere.frame;
    surface.local = large_sphere.curvature * x;
    return surface;
}

// `point` is the normal in the object's space.
fn large_sphere_uv(large_sphere: LargeSphere, point: vec3<f32>, local: vec3<f32>) -> SurfaceUv {
    return SurfaceUv(sphere_uv_at(point), vec2<bool>(true, false));
}

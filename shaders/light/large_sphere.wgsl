//@ use light/sample
//@ use light/sphere
//@ use geometry/large_sphere
// A large sphere as a light. It is sampled like a sphere (light/sphere), but the cone of directions that hit it is computed from the
// height above it.

// With D the distance from the centre, (D/r)² - 1 = c power. A point inside never counts as outside: the margin is a bound of the
// error of the power (geometry/large_sphere), with that of x.
fn large_sphere_cone(from_point: vec3<f32>, large_sphere: LargeSphere) -> SphereCone {
    let x = from_point - large_sphere.nearest;
    let power = large_sphere_power(large_sphere, x);
    let margin = UNIT_ROUNDOFF * (8.0 * dot(abs(large_sphere.inward), abs(x)) + 6.0 * large_sphere.curvature * dot(x, x));
    let upward = large_sphere_upward(large_sphere, x);
    if !(power > margin) {
        return SphereCone(-upward, 2.0, 2.0);
    }
    let excess = large_sphere.curvature * power;
    let sine = 1.0 / sqrt(1.0 + excess);
    let cosine = sqrt(excess) * sine;
    return SphereCone(-normalize(upward), sine, sine * sine / (1.0 + cosine));
}

fn large_sphere_light_sample(from_point: vec3<f32>, large_sphere: LargeSphere, u: vec2<f32>) -> DirectionSample {
    return sphere_cone_sample(large_sphere_cone(from_point, large_sphere), u);
}

fn large_sphere_light_pdf(from_point: vec3<f32>, direction: vec3<f32>, large_sphere: LargeSphere) -> f32 {
    return sphere_cone_light_pdf(large_sphere_cone(from_point, large_sphere));
}

// Whether a ray to the large sphere arrives from outside.
fn large_sphere_light_front(ray: Ray, normal: vec3<f32>, large_sphere: LargeSphere) -> bool {
    return large_sphere_power(large_sphere, ray.origin - large_sphere.nearest) > 0.0;
}

// Approximate distance to the large sphere along a ray that narrowly misses it: to the point that is nearest to it.
fn large_sphere_light_distance(ray: Ray, large_sphere: LargeSphere) -> f32 {
    return -large_sphere_line(ray, large_sphere).slope / large_sphere.curvature;
}

fn large_sphere_light_point(large_sphere: LargeSphere, u: vec2<f32>) -> LightPoint {
    let outward = sample_sphere(u);
    return LightPoint(large_sphere.nearest + (large_sphere.inward + outward) / large_sphere.curvature, outward);
}

// Light paths do not start on large spheres (src/flatten/light_paths.rs).
fn large_sphere_light_leaves(normal: vec3<f32>, direction: vec3<f32>) -> bool {
    return false;
}

//@ use data/ray
//@ use data/primitive
//@ use light/sample
//@ use light/sphere
//@ use geometry/globe
//@ use lib/float
// A globe as a light: as a sphere (light/sphere), with the cone of directions that hit it computed from the height above it.

// With D the distance from the centre, (D/r)² - 1 = c power. A point inside never counts as outside: the margin is a bound of the
// error of the power (geometry/globe), with that of x.
fn globe_cone(from_point: vec3<f32>, globe: Globe) -> SphereCone {
    let x = from_point - globe.nearest;
    let power = globe_power(globe, x);
    let margin = UNIT_ROUNDOFF * (8.0 * dot(abs(globe.inward), abs(x)) + 6.0 * globe.curvature * dot(x, x));
    let upward = globe_upward(globe, x);
    if !(power > margin) {
        return SphereCone(-upward, 2.0, 2.0);
    }
    let excess = globe.curvature * power;
    let sine = 1.0 / sqrt(1.0 + excess);
    let cosine = sqrt(excess) * sine;
    return SphereCone(-normalize(upward), sine, sine * sine / (1.0 + cosine));
}

fn globe_light_sample(from_point: vec3<f32>, globe: Globe, u: vec2<f32>) -> DirectionSample {
    return sphere_cone_sample(globe_cone(from_point, globe), u);
}

fn globe_light_pdf(from_point: vec3<f32>, direction: vec3<f32>, globe: Globe) -> f32 {
    return sphere_cone_light_pdf(globe_cone(from_point, globe));
}

// Whether a ray to the globe arrives from outside.
fn globe_light_front(ray: Ray, normal: vec3<f32>, globe: Globe) -> bool {
    return globe_power(globe, ray.origin - globe.nearest) > 0.0;
}

// Approximate distance to the globe along a ray that narrowly misses it: to the point that is nearest to it.
fn globe_light_distance(ray: Ray, globe: Globe) -> f32 {
    return -globe_line(ray, globe).slope / globe.curvature;
}

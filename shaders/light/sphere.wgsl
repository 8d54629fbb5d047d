//@ use light/sample
// A sphere as a light. From outside, directions are uniform in the cone of directions that hit it (Shirley, Wang and
// Zimmerman, "Monte Carlo Techniques for Direct Lighting Calculations", ACM TOG 15(1), 1996, section 3.2). From inside, they
// are uniform over all directions.

// The cone of directions from a point to a sphere.
struct SphereCone {
    // Unit vector towards the centre; from inside it is not normalised.
    axis: vec3<f32>,
    // Sine of the cone's half angle; 2 from inside.
    sine: f32,
    // 1 - cos of the half angle, computed as sine^2 / (1 + cos), which keeps its precision. 1 - sqrt(1 - sine^2)
    // would be 0 for sines below 2.4e-4.
    height: f32,
}

// The sine is off by at most 4 u, with u the unit of roundoff: 2 u from the length, 1 u from each difference, 1 u from the
// quotient. So a point inside never counts as outside. If it did, the far half of what it sees would never be sampled. A point
// outside may count as inside if it is within 8 u of the surface. Then half of the directions miss, and the density is still right.
fn sphere_cone(from_point: vec3<f32>, sphere: Sphere) -> SphereCone {
    let to_center = sphere.center - from_point;
    let distance = length(to_center);
    let sine = sphere.radius / distance;
    if !(sine < 1.0 - 4.0 * UNIT_ROUNDOFF) {
        return SphereCone(to_center, 2.0, 2.0);
    }
    // (D - r)(D + r) instead of 1 - sine^2. Near contact D - r is exact (Sterbenz), so only the error of D itself remains.
    let cosine = sqrt((distance - sphere.radius) * (distance + sphere.radius)) / distance;
    return SphereCone(to_center / distance, sine, sine * sine / (1.0 + cosine));
}

// 1 over the solid angle, which is 2 pi height. From inside this is 1 / (4 pi).
fn sphere_cone_pdf(cone: SphereCone) -> f32 {
    return 1.0 / (2.0 * PI * cone.height);
}

// Rounding moves some directions of the cone out of it, where they miss the sphere, and moves none in. With d the rounding error,
// that would lose a fraction 2 d / sine of the light. So directions are drawn from a cone that is narrower by a bound of d, and
// the density stays that of the full cone. The estimate is then the mean of the integrand over the narrower cone, times the full
// solid angle. It is off by d times the change of the integrand over the cone, or by less if the integrand is smooth. d is 3 u
// from the axis and the basis, 4 u from the three products and two sums, and 4 u from the perpendicular in the intersection test.
const SPHERE_LIMB: f32 = 12.0 * UNIT_ROUNDOFF;

// For a smaller sine, the square of the density would come near the end of f32's range (MIS weights need squares), and no ray
// of f32 could be aimed at the sphere. Such a sphere is not sampled.
const SPHERE_LEAST_SINE: f32 = 0x1p-31f;

fn sphere_cone_sample(cone: SphereCone, u: vec2<f32>) -> DirectionSample {
    if cone.sine > 1.0 {
        return DirectionSample(sample_sphere(u), sphere_cone_pdf(cone));
    }
    if !(cone.sine > SPHERE_LEAST_SINE) {
        return NO_DIRECTION_SAMPLE;
    }
    let narrower = max(cone.sine - SPHERE_LIMB, 0.0) / cone.sine;
    let height = u.x * (cone.height * (narrower * narrower));
    let across = sqrt(height * (2.0 - height));
    let local = vec3<f32>(across * sample_circle(u.y), 1.0 - height);
    return DirectionSample(normalize(from_basis(basis_around(cone.axis), local)), sphere_cone_pdf(cone));
}

// The pdf with which light sampling draws a direction that hits the sphere.
fn sphere_cone_light_pdf(cone: SphereCone) -> f32 {
    return select(0.0, sphere_cone_pdf(cone), cone.sine > SPHERE_LEAST_SINE);
}

fn sphere_light_sample(from_point: vec3<f32>, sphere: Sphere, u: vec2<f32>) -> DirectionSample {
    return sphere_cone_sample(sphere_cone(from_point, sphere), u);
}

fn sphere_light_pdf(from_point: vec3<f32>, direction: vec3<f32>, sphere: Sphere) -> f32 {
    return sphere_cone_light_pdf(sphere_cone(from_point, sphere));
}

// Whether a ray to the sphere arrives from outside. The normal at the hit cannot tell: if the sphere is tiny as seen from the
// ray's origin, its normal has no correct digits.
fn sphere_light_front(ray: Ray, normal: vec3<f32>, sphere: Sphere) -> bool {
    return length(ray.origin - sphere.center) > sphere.radius;
}

// Approximate distance to the near side of the sphere along a ray that narrowly misses it.
fn sphere_light_distance(ray: Ray, sphere: Sphere) -> f32 {
    return dot(sphere.center - ray.origin, ray.direction) - sphere.radius;
}

fn sphere_light_point(sphere: Sphere, u: vec2<f32>) -> LightPoint {
    let outward = sample_sphere(u);
    return LightPoint(sphere.center + sphere.radius * outward, outward);
}

// Whether light paths leave the light in this direction: from the outside of a closed one.
fn sphere_light_leaves(normal: vec3<f32>, direction: vec3<f32>) -> bool {
    return dot(normal, direction) > 0.0;
}

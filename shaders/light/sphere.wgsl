//@ use data/ray
//@ use data/primitive
//@ use light/sample
//@ use lib/basis
//@ use lib/float
//@ use lib/sampling
// A sphere as a light: directions uniform in the cone that it fills (Shirley, Wang and Zimmerman, "Monte Carlo Techniques
// for Direct Lighting Calculations", ACM TOG 15(1), 1996, section 3.2), or, from inside, uniform over all.

// What of a sphere is seen from a point.
struct SphereCone {
    // Towards the centre; not a unit vector where the point is the centre.
    axis: vec3<f32>,
    // Sine of the cone's half angle, or 2 from inside.
    sine: f32,
    // 1 - cos of the half angle. sine^2 / (1 + cos) keeps its digits, where 1 - sqrt(1 - sine^2) is 0 below 2.4e-4.
    height: f32,
}

// The distance is off by 4 u at most, u the unit of roundoff (2 of the length, 1 of each difference, 1 of the quotient), so
// that a point that is inside never counts as outside, whence the far half of what it sees would never be sampled. One that
// is outside may count as inside, to within 8 u of the surface: then half of the directions miss, and the density is right.
fn sphere_cone(from_point: vec3<f32>, sphere: Sphere) -> SphereCone {
    let to_center = sphere.center - from_point;
    let distance = length(to_center);
    let sine = sphere.radius / distance;
    if !(sine < 1.0 - 4.0 * UNIT_ROUNDOFF) {
        return SphereCone(to_center, 2.0, 2.0);
    }
    // (D - r)(D + r) instead of 1 - sine^2: D - r is exact near contact (Sterbenz), and D's own error is all that is left.
    let cosine = sqrt((distance - sphere.radius) * (distance + sphere.radius)) / distance;
    return SphereCone(to_center / distance, sine, sine * sine / (1.0 + cosine));
}

// One over the solid angle 2 pi height: from inside 1 / 4 pi.
fn sphere_cone_pdf(cone: SphereCone) -> f32 {
    return 1.0 / (2.0 * PI * cone.height);
}

// Directions that lie within the cone but were rounded out of it would miss, with none rounded in: a loss of 2 d / sine, d
// the rounding. So the cone is drawn narrower by a bound of d, while the density stays that of the whole cone: what is added
// up is the integrand's mean over the narrower cone times the whole solid angle, which is off by d times what the integrand
// changes over the cone, and less than that where it is smooth. d: 3 u from the axis and the basis, 4 u from
// the three products and two sums, 4 u from the test's own perpendicular.
const SPHERE_LIMB: f32 = 12.0 * UNIT_ROUNDOFF;

// Below this a density's square would come near the end of f32's range (its weights in multiple importance sampling need
// squares), and no ray of f32 could be aimed at the sphere: it gives nothing.
const SPHERE_LEAST_SINE: f32 = 0x1p-31f;

fn sphere_light_sample(from_point: vec3<f32>, sphere: Sphere, u: vec2<f32>) -> DirectionSample {
    let cone = sphere_cone(from_point, sphere);
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

// The density with which a direction that meets the sphere is sampled.
fn sphere_light_pdf(from_point: vec3<f32>, direction: vec3<f32>, sphere: Sphere) -> f32 {
    let cone = sphere_cone(from_point, sphere);
    return select(0.0, sphere_cone_pdf(cone), cone.sine > SPHERE_LEAST_SINE);
}

// Whether a ray to the sphere comes from outside. The normal where it arrives does not tell: of a sphere that is tiny from the
// ray's origin it has no digits.
fn sphere_light_front(ray: Ray, normal: vec3<f32>, sphere: Sphere) -> bool {
    return length(ray.origin - sphere.center) > sphere.radius;
}

// About how far the near side of the sphere is along a ray that passes it by.
fn sphere_light_distance(ray: Ray, sphere: Sphere) -> f32 {
    return dot(sphere.center - ray.origin, ray.direction) - sphere.radius;
}

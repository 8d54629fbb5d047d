//@ use geometry/quad_plane
//@ use light/sample
//@ use light/spherical
// A parallelogram as a light: directions are uniform in its solid angle, at any distance and size. A diagonal divides it into
// two triangles. They are sampled as one fan around the corner, so that the direction is continuous in u.x across the diagonal.
// Rectangles are sampled in the same way. The map of Ureña, Fajardo and King ("An Area-Preserving Parametrization for Spherical
// Rectangles", EGSR 2013) needs sums of four arc cosines minus 2 pi, which have no precision left in f32 for quads far away.

// A parallelogram as seen from the point of the event.
struct SphericalQuad {
    // The four corners in their order around the quad.
    first: Corner,
    second: Corner,
    third: Corner,
    fourth: Corner,
    determinant: f32,
    // Solid angles of the triangle first, second, third and of the triangle first, fourth, third.
    areas: vec2<f32>,
}

fn spherical_quad(corner: vec3<f32>, u: vec3<f32>, v: vec3<f32>) -> SphericalQuad {
    let first = corner_at(corner);
    let second = corner_at(corner + u);
    let third = corner_at(corner + (u + v));
    let fourth = corner_at(corner + v);
    let determinant = dot(corner, cross(u, v));
    let areas = vec2<f32>(
        spherical_area(first, second, third, abs(determinant)),
        spherical_area(first, fourth, third, abs(determinant)),
    );
    return SphericalQuad(first, second, third, fourth, determinant, areas);
}

// The direction for the solid angle `part` of the fan and the fraction `share` of the arc's height (light/spherical).
fn spherical_quad_direction(quad: SphericalQuad, u: vec3<f32>, v: vec3<f32>, part: f32, share: f32) -> vec3<f32> {
    let in_first = part < quad.areas.x;
    var second = quad.fourth;
    if in_first {
        second = quad.second;
    }
    let to_second = select(v, u, in_first);
    let to_third = select(u, v, in_first);
    let determinant = select(-quad.determinant, quad.determinant, in_first);
    let rest = max(quad.areas.y - (part - quad.areas.x), 0.0);
    let area = select(rest, part, in_first);
    return spherical_direction(quad.first, second, quad.third, to_second, to_third, determinant, area, share);
}

fn quad_light_sample(from_point: vec3<f32>, quad: Quad, u: vec2<f32>) -> DirectionSample {
    let seen = spherical_quad(quad.corner - from_point, quad.u, quad.v);
    let area = seen.areas.x + seen.areas.y;
    if !(area > 0.0) {
        return NO_DIRECTION_SAMPLE;
    }
    return DirectionSample(spherical_quad_direction(seen, quad.u, quad.v, u.x * area, u.y), 1.0 / area);
}

// The pdf with which light sampling draws a direction that hits the quad.
fn quad_light_pdf(from_point: vec3<f32>, direction: vec3<f32>, quad: Quad) -> f32 {
    let seen = spherical_quad(quad.corner - from_point, quad.u, quad.v);
    let area = seen.areas.x + seen.areas.y;
    return select(0.0, 1.0 / area, area > 0.0);
}

// Whether a ray to the quad arrives at its front, the side of its normal.
fn quad_light_front(ray: Ray, normal: vec3<f32>, quad: Quad) -> bool {
    return dot(ray.direction, normal) < 0.0;
}

// Distance to the plane of the quad along a ray that narrowly misses the quad.
fn quad_light_distance(ray: Ray, quad: Quad) -> f32 {
    return quad_plane_distance(ray, quad);
}

fn quad_light_point(quad: Quad, u: vec2<f32>) -> LightPoint {
    return LightPoint(quad.corner + (u.x * quad.u + u.y * quad.v), vec3<f32>(0.0));
}

// Light paths leave a flat light on both sides.
fn quad_light_leaves(normal: vec3<f32>, direction: vec3<f32>) -> bool {
    return true;
}

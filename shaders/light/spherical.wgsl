// Spherical triangles: their solid angle, and directions uniform in it, by Arvo's method ("Stratified Sampling of Spherical
// Triangles", SIGGRAPH 1995). An arc from p to a point of the arc a c cuts the triangle p, a, c so that the part next to a has a given
// fraction of the solid angle. The direction lies on this arc, at a given fraction of the arc's height. Arvo's formulas use the angles
// of the triangle, and the sum of the angles minus pi suffers cancellation in small triangles. The formulas here use tangents only.
//
// Own derivation. Let t be the unit tangent at a towards c, and m = p.a, q = p.t, n = |a.(p x t)|, so that m^2 + q^2 + n^2 = 1.
// For the point a cos s + t sin s of the arc a c, the formula of Van Oosterom and Strackee ("The Solid Angle of a Plane
// Triangle", IEEE Trans. Biomed. Eng. 30(2), 1983, equation 8) gives the solid angle E of the part next to a:
//     tan(E/2) = n sin s / ((1 + m)(1 + cos s) + q sin s),   so   tan(s/2) = (1 + m) sin(E/2) / (n cos(E/2) - q sin(E/2)).
// With this s, the components of the point as seen from p, along the tangent at p towards a and across it, are, without common factors,
//     n (cos E - m) - q sin E   and   n sin E - q (1 - cos E).
// They are the direction in which the cutting arc leaves p. Close above a triangle, n approaches 0 and the arcs approach half
// circles. The ratio of the two components then approaches tan(E/2), with full precision.

// A corner as seen from the point of the event.
struct Corner {
    direction: vec3<f32>,
    distance: f32,
}

fn corner_at(offset: vec3<f32>) -> Corner {
    let distance = length(offset);
    return Corner(offset / distance, distance);
}

// Solid angle of the triangle with these three corners; `volume` is the absolute value of their determinant. It is 0 in the
// plane of the triangle, and where the square of the density would come near the end of f32's range.
fn spherical_area(p: Corner, a: Corner, c: Corner, volume: f32) -> f32 {
    let shape = volume / p.distance / a.distance / c.distance;
    let denominator = 1.0 + dot(p.direction, a.direction) + dot(a.direction, c.direction) + dot(c.direction, p.direction);
    let area = 2.0 * angle_of(shape, denominator);
    return select(0.0, area, shape > 0x1p-59f);
}

// The direction on the arc that cuts off the solid angle `part`, at the fraction v of the arc's height. `to_a` is the edge from
// corner p to a, and `to_c` that from a to c. They are differences of corners, which are more precise than differences of directions.
fn spherical_direction(
    p: Corner,
    a: Corner,
    c: Corner,
    to_a: vec3<f32>,
    to_c: vec3<f32>,
    determinant: f32,
    part: f32,
    v: f32,
) -> vec3<f32> {
    // The components of the two edges perpendicular to the directions of their first corners.
    let across_a = to_a - dot(p.direction, to_a) * p.direction;
    let across_c = to_c - dot(a.direction, to_c) * a.direction;
    let length_a = length(across_a);
    let length_c = length(across_c);
    if !(length_a > 0.0) || !(length_c > 0.0) {
        return p.direction;
    }
    let tangent_a = across_a / length_a;
    let side = cross(p.direction, tangent_a) * select(-1.0, 1.0, determinant > 0.0);
    let m = dot(p.direction, a.direction);
    let sine_a = length_a / a.distance;
    // 1 + m and 1 - m. Their product is the square of the sine, so the smaller one is computed from the larger one.
    let above = select(sine_a * sine_a / (1.0 - m), 1.0 + m, m > 0.0);
    let below = select(1.0 - m, sine_a * sine_a / (1.0 + m), m > 0.0);
    let q = -dot(to_a, across_c) / (length_c * p.distance);
    let n = abs(determinant) / p.distance / a.distance / length_c;

    let rotation = sine_and_rise(part);
    let half = sine_and_rise(0.5 * part);
    // tan(s/2) = y / x, scaled so that no square underflows.
    let y = half.x * above;
    let x = max(n * (1.0 - half.y) - q * half.x, 0.0);
    let largest = max(max(x, y), 0x1p-120f);
    let t = vec2<f32>(x, y) / largest;
    let scale = 2.0 / max(dot(t, t), 0x1p-120f);
    // The height of the arc is 1 - p.(a cos s + t sin s), and the direction is at the fraction v of it.
    let height = v * clamp(below + scale * t.y * (t.y * m - t.x * q), 0.0, 2.0);

    let leaving = vec2<f32>(n * (below - rotation.y) - q * rotation.x, n * rotation.x - q * rotation.y);
    let size = max(abs(leaving.x), abs(leaving.y));
    let heading = select(vec2<f32>(1.0, 0.0), normalize(leaving / size), size > 0.0);
    let tangent = heading.x * tangent_a + heading.y * side;
    return normalize((1.0 - height) * p.direction + sqrt(height * (2.0 - height)) * tangent);
}

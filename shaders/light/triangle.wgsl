//@ use geometry/triangle
//@ use light/sample
//@ use light/spherical
// A triangle as a light: directions are uniform in its solid angle, at any distance and size. It never switches to sampling by
// area: light/spherical is as precise for small triangles as for large ones, and the density is the same for all directions.

// The determinant of the corners as seen from the point. Its sign tells from which side the point sees the triangle.
fn triangle_determinant(from_point: vec3<f32>, a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> f32 {
    return dot(a - from_point, triangle_cross(a, b, c));
}

fn triangle_light_sample(
    from_point: vec3<f32>,
    a: vec3<f32>,
    b: vec3<f32>,
    c: vec3<f32>,
    u: vec2<f32>,
) -> DirectionSample {
    let first = corner_at(a - from_point);
    let second = corner_at(b - from_point);
    let third = corner_at(c - from_point);
    let determinant = triangle_determinant(from_point, a, b, c);
    let area = spherical_area(first, second, third, abs(determinant));
    if !(area > 0.0) {
        return NO_DIRECTION_SAMPLE;
    }
    let direction = spherical_direction(first, second, third, b - a, c - b, determinant, u.x * area, u.y);
    return DirectionSample(direction, 1.0 / area);
}

// The pdf with which light sampling draws a direction that hits the triangle.
fn triangle_light_pdf(
    from_point: vec3<f32>,
    direction: vec3<f32>,
    a: vec3<f32>,
    b: vec3<f32>,
    c: vec3<f32>,
) -> f32 {
    let volume = abs(triangle_determinant(from_point, a, b, c));
    let area = spherical_area(corner_at(a - from_point), corner_at(b - from_point), corner_at(c - from_point), volume);
    return select(0.0, 1.0 / area, area > 0.0);
}

// A point of the triangle (Turk, "Generating Random Points in Triangles", Graphics Gems, 1990).
fn triangle_light_point(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, u: vec2<f32>) -> LightPoint {
    let root = sqrt(u.x);
    return LightPoint(a + root * ((b - a) + u.y * (c - b)), vec3<f32>(0.0));
}

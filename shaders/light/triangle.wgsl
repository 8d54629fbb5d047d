//@ use geometry/instance
//@ use geometry/sheared_triangle
//@ use geometry/triangle
//@ use light/sample
//@ use light/spherical
// A triangle as a light: directions are uniform in its solid angle, at any distance and size. It never switches to sampling by
// area: light/spherical is as precise for small triangles as for large ones, and the density is the same for all directions.

// The determinant of the corners as seen from the point. Its sign tells from which side the point sees the triangle.
fn triangle_determinant(from_point: vec3<f32>, corners: Corners) -> f32 {
    return dot(corners.a - from_point, triangle_cross(corners.a, corners.b, corners.c));
}

fn corners_sample(from_point: vec3<f32>, corners: Corners, u: vec2<f32>) -> DirectionSample {
    let first = corner_at(corners.a - from_point);
    let second = corner_at(corners.b - from_point);
    let third = corner_at(corners.c - from_point);
    let determinant = triangle_determinant(from_point, corners);
    let area = spherical_area(first, second, third, abs(determinant));
    if !(area > 0.0) {
        return NO_DIRECTION_SAMPLE;
    }
    let to_b = corners.b - corners.a;
    let direction = spherical_direction(first, second, third, to_b, corners.c - corners.b, determinant, u.x * area, u.y);
    return DirectionSample(direction, 1.0 / area);
}

// The pdf with which light sampling draws a direction that hits the triangle.
fn corners_pdf(from_point: vec3<f32>, corners: Corners) -> f32 {
    let first = corner_at(corners.a - from_point);
    let second = corner_at(corners.b - from_point);
    let third = corner_at(corners.c - from_point);
    let area = spherical_area(first, second, third, abs(triangle_determinant(from_point, corners)));
    return select(0.0, 1.0 / area, area > 0.0);
}

// A point of the triangle (Turk, "Generating Random Points in Triangles", Graphics Gems, 1990).
fn corners_point(corners: Corners, u: vec2<f32>) -> LightPoint {
    let root = sqrt(u.x);
    let point = corners.a + root * ((corners.b - corners.a) + u.y * (corners.c - corners.b));
    return LightPoint(point, vec3<f32>(0.0));
}

fn triangle_light_sample(from_point: vec3<f32>, triangle: Triangle, u: vec2<f32>) -> DirectionSample {
    return corners_sample(from_point, corners_in_render_space(triangle), u);
}

fn triangle_light_pdf(from_point: vec3<f32>, direction: vec3<f32>, triangle: Triangle) -> f32 {
    return corners_pdf(from_point, corners_in_render_space(triangle));
}

fn triangle_light_point(triangle: Triangle, u: vec2<f32>) -> LightPoint {
    return corners_point(corners_in_render_space(triangle), u);
}

// Whether a ray to the face arrives at its front, the side of its normal.
fn triangle_light_front(ray: Ray, normal: vec3<f32>, triangle: Triangle) -> bool {
    return dot(ray.direction, normal) < 0.0;
}

// Distance to the plane of the face along a ray that narrowly misses the face.
fn triangle_light_distance(ray: Ray, triangle: Triangle) -> f32 {
    let here = to_mesh(triangle.instance, ray);
    let corners = corners_of(triangle.face);
    let normal = triangle_cross(corners.a, corners.b, corners.c);
    return dot(corners.a - here.origin, normal) / dot(here.direction, normal);
}

// Light paths leave a flat light on both sides.
fn triangle_light_leaves(normal: vec3<f32>, direction: vec3<f32>) -> bool {
    return true;
}

//@ use light/sample
//@ use geometry/quad_plane
// A disk as a light: points are uniform in its area. Directions that are uniform in the solid angle of the square around it were tried, as
// samples of 0 where they miss the disk. From a distance of one radius on, their error is 1.3 to 14 times as large; closer by, 0.8 times.

fn disk_coordinates(u: vec2<f32>) -> vec2<f32> {
    return 0.5 + 0.5 * sample_disk(u);
}

fn disk_light_sample(from_point: vec3<f32>, square: Quad, u: vec2<f32>) -> DirectionSample {
    let at = disk_coordinates(u);
    let direction = normalize((square.corner - from_point) + (at.x * square.u + at.y * square.v));
    return DirectionSample(direction, disk_light_pdf(from_point, direction, square));
}

// The pdf with which light sampling draws a direction that hits the disk: 1 over its area, in solid angle. It is 0 in the plane of the
// disk, and where its square would come near the end of f32's range (MIS weights need squares).
fn disk_light_pdf(from_point: vec3<f32>, direction: vec3<f32>, square: Quad) -> f32 {
    let diameters = quad_plane_distance(Ray(from_point, direction), square) / length(square.u);
    let pdf = 4.0 / PI * diameters * diameters / abs(dot(direction, square.normal));
    return select(0.0, pdf, pdf < 0x1p59f);
}

// Whether a ray to the disk arrives at its front, the side of its normal.
fn disk_light_front(ray: Ray, normal: vec3<f32>, square: Quad) -> bool {
    return dot(ray.direction, normal) < 0.0;
}

// Distance to the plane of the disk along a ray that narrowly misses the disk.
fn disk_light_distance(ray: Ray, square: Quad) -> f32 {
    return quad_plane_distance(ray, square);
}

fn disk_light_point(square: Quad, u: vec2<f32>) -> LightPoint {
    let at = disk_coordinates(u);
    return LightPoint(square.corner + (at.x * square.u + at.y * square.v), vec3<f32>(0.0));
}

// Light paths leave a flat light on both sides.
fn disk_light_leaves(normal: vec3<f32>, direction: vec3<f32>) -> bool {
    return true;
}

// Where a ray leaves a surface, with one fraction for all shapes (`--offset fast`): the point moved along the normal, to the side that
// the ray goes to, by a fraction of its largest coordinate, which is about its distance from the camera. No shape's own bound
// of its error is computed. What is smaller than the fraction of its distance loses its inside and its contacts, and a shape that is many
// thousand times as large as its distance meets the rays that leave it again.

// Above the bound of a sphere, 4 u (|c| + r), where its radius is up to 128 times its distance, as that of the ground of "Ray Tracing in
// One Weekend" is.
const OFFSET_FRACTION: f32 = 0x1p-14f;

fn leave_surface(point: vec3<f32>, error: f32, normal: vec3<f32>, direction: vec3<f32>) -> vec3<f32> {
    let p = abs(point);
    let by = OFFSET_FRACTION * max(max(p.x, p.y), p.z);
    return point + select(-by, by, dot(direction, normal) >= 0.0) * normal;
}

// The origin of a ray that leaves a surface, with the same fraction for all shapes (`--offset fast`). The point moves along the
// normal, to the side that the ray goes to, by a fraction of its largest coordinate, which is about its distance from the
// camera. No error bound is computed. A shape smaller than this fraction of its distance loses its inside, and light leaks
// through its contacts. On a shape many thousand times larger than its distance, rays hit the surface that they leave.

// Larger than a sphere's bound, 4 u (|c| + r), for radii up to 128 times the distance. The ground of "Ray Tracing in
// One Weekend" is such a sphere.
const OFFSET_FRACTION: f32 = 0x1p-14f;

fn leave_surface(point: vec3<f32>, error: f32, normal: vec3<f32>, direction: vec3<f32>) -> vec3<f32> {
    let p = abs(point);
    let by = OFFSET_FRACTION * max(max(p.x, p.y), p.z);
    return point + select(-by, by, dot(direction, normal) >= 0.0) * normal;
}

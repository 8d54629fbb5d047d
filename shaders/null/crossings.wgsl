//@ use data/hit
//@ use data/motion
//@ use data/ray
// No convex body is passed: a ray hits the first side that it meets.
fn interval_of_body(code: u32, pose: Pose, ray: Ray) -> vec2<f32> {
    return vec2<f32>(0.0);
}

fn with_side(hit: Hit, pose: Pose, ray: Ray) -> Hit {
    return hit;
}

fn ray_to_hit(hit: Hit, pose: Pose, ray: Ray) -> RayToHit {
    return RayToHit(ray, hit.t);
}

// The point of the hit, in render space.
fn position(path: ptr<function, Path>) -> vec3<f32> {
    return (*path).ray.origin + (*path).t * (*path).ray.direction;
}

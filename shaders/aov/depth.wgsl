//@ use choice/camera_pose
// The distance to the hit along the camera's axis. A lens lies across it, so that all of its rays start at depth 0.
fn depth(path: ptr<function, Path>) -> f32 {
    return (*path).t * dot((*path).ray.direction, camera_forward());
}

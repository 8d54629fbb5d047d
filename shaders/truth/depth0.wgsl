//@ use truth/word
//@ use choice/camera_pose
// The distance to the hit along the camera's axis.
fn depth0_of(path: ptr<function, Path>) -> u32 {
    let depth = (*path).t * dot((*path).ray.direction, camera_forward());
    return select(0u, word_of(depth), has_hit(path));
}

//@ use data/motion
//@ use data/primitive
// Meshes rest.
fn moved_instance(instance: Instance, pose: Pose) -> Instance {
    return instance;
}

//@ use bind/instances
//@ use geometry/triangle
//@ use scene/at_run_time
// Faces of meshes have no table of their own: `index` is that of the face in `meshes`.
fn triangle_at(index: u32, instance: u32) -> Triangle {
    let of_mesh = instances[at_run_time(instance)];
    return Triangle(of_mesh, index, of_mesh.to_light + index);
}

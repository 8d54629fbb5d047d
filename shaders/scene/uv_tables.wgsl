//@ implements uv_tables when further_uv
//@ use data/surface
//@ use data/hit
//@ use data/primitive
//@ use choice/uv
//@ use scene/at_run_time
//@ use scene/meshes
// Meshes with several tables of texture coordinates.

// Returns an instance that reads the texture coordinates of the table of this number.
fn with_table(instance: Instance, number: f32) -> Instance {
    var result = instance;
    result.to_uvs *= u32(number) + 1u;
    return result;
}

// Like surface_uv. `number` is the phase of the texture's frame: for an image, the number of its table. Other textures use no texture
// coordinates.
fn uv_in_table(number: f32, hit: Hit, point: vec3<f32>, local: vec3<f32>) -> SurfaceUv {
    if number <= 0.0 || primitive_kind(hit.code) != KIND_TRIANGLE {
        return surface_uv(hit, point, local);
    }
    return mesh_uv(with_table(instances[at_run_time(hit.instance)], number), primitive_index(hit.code), local);
}

//@ without
//@ use data/surface
//@ use data/hit
//@ use choice/uv
// Each mesh has one table.
fn uv_in_table(number: f32, hit: Hit, point: vec3<f32>, local: vec3<f32>) -> SurfaceUv {
    return surface_uv(hit, point, local);
}

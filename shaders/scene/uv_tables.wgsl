//@ use data/surface
//@ use data/hit
//@ use data/primitive
//@ use choice/uv
//@ use scene/at_run_time
//@ use scene/meshes
// Texture coordinates of images that have tables of their own on meshes.

// An instance whose mesh has its texture coordinates in the table of this number.
fn with_table(instance: Instance, number: f32) -> Instance {
    var own = instance;
    own.to_uvs *= u32(number) + 1u;
    return own;
}

// As surface_uv; `number` is the phase of the texture's frame. It is the number of a table only if the texture is an image. Other kinds of
// texture use no texture coordinates.
fn uv_in_table(number: f32, hit: Hit, point: vec3<f32>, local: vec3<f32>) -> SurfaceUv {
    if number <= 0.0 || primitive_kind(hit.code) != KIND_TRIANGLE {
        return surface_uv(hit, point, local);
    }
    return mesh_uv(with_table(instances[at_run_time(hit.instance)], number), primitive_index(hit.code), local);
}

//@ implements uv_tables when further_uv & !(image_wrap & mesh)
//@ use bind/triangles
//@ use choice/uv
//@ use scene/with_table
// Meshes with several tables of texture coordinates.

// Like surface_uv. `number` is the phase of the texture's frame: for an image, the number of its table. Other textures use no texture
// coordinates.
fn uv_in_table(number: f32, hit: Hit, point: vec3<f32>, local: vec3<f32>) -> SurfaceUv {
    if number <= 0.0 || primitive_kind(hit.code) != KIND_TRIANGLE {
        return surface_uv(hit, point, local);
    }
    return triangle_uv(with_table(triangle_at(primitive_index(hit.code), hit.instance), number), point, local);
}

//@ without
//@ use choice/uv
// Each mesh has one table.
fn uv_in_table(number: f32, hit: Hit, point: vec3<f32>, local: vec3<f32>) -> SurfaceUv {
    return surface_uv(hit, point, local);
}

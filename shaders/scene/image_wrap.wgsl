//@ implements uv_tables when image_wrap & mesh
//@ use bind/triangles
//@ use choice/uv
//@ use scene/with_table
// Meshes with images that do not repeat. Like uv_in_table of several tables; a quarter more than the table's number clamps, and a half more
// mirrors.
fn uv_in_table(number: f32, hit: Hit, point: vec3<f32>, local: vec3<f32>) -> SurfaceUv {
    if number <= 0.0 || primitive_kind(hit.code) != KIND_TRIANGLE {
        return surface_uv(hit, point, local);
    }
    let triangle = with_table(triangle_at(primitive_index(hit.code), hit.instance), number);
    if fract(number) == 0.0 {
        return triangle_uv(triangle, point, local);
    }
    let uv = interpolated_uv(triangle, local);
    let mirrored = abs(uv - 2.0 * round(0.5 * uv));
    return SurfaceUv(select(saturate(uv), mirrored, fract(number) == 0.5), vec2<bool>(false));
}

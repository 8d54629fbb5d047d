//@ implements mesh_normal_map when further_uv
//@ use bind/frames
//@ use bind/triangles
//@ use choice/moved_triangle
//@ use geometry/instance
//@ use choice/uv_tables
//@ use choice/vertex_tangents
//@ use tangent/triangle
// Normal maps on meshes with a table of texture coordinates for the map.

// Returns the vector `mapped` of a normal map in the frame of `normal`. `number` is that of the map's table.
fn normal_on_mesh(mapped: vec3<f32>, normal: vec3<f32>, hit: Hit, surface: Surface, number: f32) -> vec3<f32> {
    let face = triangle_at(primitive_index(hit.code), hit.instance);
    let moved = with_table(moved_triangle(face, surface.pose), number);
    if has_tangents(moved.face) {
        let otherwise = rotated_to_mesh(moved.instance, normal);
        return rotated_from_mesh(moved.instance, normal_by_tangents(mapped, otherwise, moved, surface.local));
    }
    return normal_of_map(mapped, normal, triangle_tangents(surface, moved, frames[surface.frame]));
}

fn has_own_table(hit: Hit) -> bool {
    return primitive_kind(hit.code) == KIND_TRIANGLE;
}

//@ without
// Maps have the tables of colours.
fn normal_on_mesh(mapped: vec3<f32>, normal: vec3<f32>, hit: Hit, surface: Surface, number: f32) -> vec3<f32> {
    return normal;
}

fn has_own_table(hit: Hit) -> bool {
    return false;
}

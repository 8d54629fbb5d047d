//@ implements mesh_normal_map when further_uv
//@ use data/hit
//@ use data/primitive
//@ use data/surface
//@ use bind/instances
//@ use choice/moved_instance
//@ use lib/tangents
//@ use scene/at_run_time
//@ use scene/uv_tables
//@ use choice/vertex_tangents
//@ use scene/mesh_tangents
// Normal maps on meshes with a table of texture coordinates for the map.

// Returns the vector `mapped` of a normal map in the frame of `normal`. `number` is that of the map's table.
fn normal_on_mesh(mapped: vec3<f32>, normal: vec3<f32>, hit: Hit, surface: Surface, number: f32) -> vec3<f32> {
    let index = primitive_index(hit.code);
    let instance = with_table(moved_instance(instances[at_run_time(hit.instance)], surface.pose), number);
    if has_tangents(index) {
        return rotated_from_mesh(instance, normal_by_tangents(mapped, rotated_to_mesh(instance, normal), instance, index, surface.local));
    }
    return normal_of_map(mapped, normal, mesh_tangents(instance, index));
}

fn has_own_table(hit: Hit) -> bool {
    return primitive_kind(hit.code) == KIND_TRIANGLE;
}

//@ without
//@ use data/hit
//@ use data/surface
// Maps have the tables of colours.
fn normal_on_mesh(mapped: vec3<f32>, normal: vec3<f32>, hit: Hit, surface: Surface, number: f32) -> vec3<f32> {
    return normal;
}

fn has_own_table(hit: Hit) -> bool {
    return false;
}

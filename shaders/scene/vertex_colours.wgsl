//@ use data/hit
//@ use data/surface
//@ use data/material
//@ use data/primitive
//@ use bind/details
//@ use bind/instances
//@ use scene/at_run_time
//@ use scene/meshes
// The colour of a mesh's vertices at a hit, if it multiplies that of the material; else white.
fn vertex_colour(hit: Hit, surface: Surface) -> vec3<f32> {
    if details[surface.material].vertex_colours == NO_DETAIL || primitive_kind(hit.code) != KIND_TRIANGLE {
        return vec3<f32>(1.0);
    }
    return mesh_colour(instances[at_run_time(hit.instance)], primitive_index(hit.code), surface.local);
}

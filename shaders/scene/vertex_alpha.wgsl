//@ use data/hit
//@ use data/surface
//@ use data/material
//@ use data/primitive
//@ use bind/details
//@ use bind/instances
//@ use scene/at_run_time
//@ use scene/meshes
// The alpha of a mesh's vertices at a hit, if it multiplies that of the material; else 1.
fn vertex_alpha(hit: Hit, surface: Surface) -> f32 {
    if details[surface.material].vertex_alpha == NO_DETAIL || primitive_kind(hit.code) != KIND_TRIANGLE {
        return 1.0;
    }
    return mesh_alpha(instances[at_run_time(hit.instance)], primitive_index(hit.code), surface.local);
}

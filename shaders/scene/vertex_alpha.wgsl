//@ implements vertex_alpha when scene.vertex_alpha & alpha & mesh
//@ use bind/extensions
//@ use bind/instances
//@ use scene/at_run_time
//@ use scene/vertices
// A material's alpha times that of the mesh's vertices at a hit, if the material uses it.
fn times_vertex_alpha(alpha: f32, hit: Hit, surface: Surface) -> f32 {
    if extensions[surface.material].vertex_alpha == NO_EXTENSION || primitive_kind(hit.code) != KIND_TRIANGLE {
        return alpha;
    }
    return alpha * mesh_alpha(instances[at_run_time(hit.instance)], primitive_index(hit.code), surface.local);
}

//@ without
// No mesh has an alpha of its vertices.
fn times_vertex_alpha(alpha: f32, hit: Hit, surface: Surface) -> f32 {
    return alpha;
}

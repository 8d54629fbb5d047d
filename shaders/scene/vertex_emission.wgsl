//@ implements vertex_emission when scene.vertex_emission & mesh
//@ use bind/extensions
//@ use bind/instances
//@ use scene/at_run_time
//@ use scene/vertices
// The radiance that a material emits times the colour of the mesh's vertices at a hit, if the material uses it.
fn times_vertex_emission(radiance: vec3<f32>, hit: Hit, surface: Surface) -> vec3<f32> {
    if extensions[surface.material].vertex_emission == NO_EXTENSION || primitive_kind(hit.code) != KIND_TRIANGLE {
        return radiance;
    }
    return radiance * mesh_colour(instances[at_run_time(hit.instance)], primitive_index(hit.code), surface.local);
}

//@ without
// No mesh emits by the colours of its vertices.
fn times_vertex_emission(radiance: vec3<f32>, hit: Hit, surface: Surface) -> vec3<f32> {
    return radiance;
}

//@ implements vertex_colours when vertex_colours & mesh
//@ use bind/extensions
//@ use bind/instances
//@ use scene/at_run_time
//@ use scene/vertices
// A material's colour times that of the mesh's vertices at a hit, if the material uses it.
fn times_vertex_colour(colour: vec3<f32>, hit: Hit, surface: Surface) -> vec3<f32> {
    if extensions[surface.material].vertex_colours == NO_EXTENSION || primitive_kind(hit.code) != KIND_TRIANGLE {
        return colour;
    }
    return colour * mesh_colour(instances[at_run_time(hit.instance)], primitive_index(hit.code), surface.local);
}

//@ without
// No mesh has colours of vertices.
fn times_vertex_colour(colour: vec3<f32>, hit: Hit, surface: Surface) -> vec3<f32> {
    return colour;
}

//@ use data/hit
//@ use data/primitive
//@ use data/surface
//@ use bind/instances
//@ use choice/moved_instance
//@ use lib/octahedral
//@ use lib/tangents
//@ use scene/at_run_time
//@ use scene/meshes
//@ use scene/uv_tables
//@ use scene/mesh_tangents
// Normal maps on meshes with a table of texture coordinates for the map.

// Returns the vector `mapped` of a normal map in the frame of `normal`. `number` is that of the map's table.
fn normal_on_mesh(mapped: vec3<f32>, normal: vec3<f32>, hit: Hit, surface: Surface, number: f32) -> vec3<f32> {
    let index = primitive_index(hit.code);
    let instance = with_table(moved_instance(instances[at_run_time(hit.instance)], surface.pose), number);
    //@ if vertex_tangents & further_uv
    if meshes[meshes[index].x].w != NO_NORMAL {
        return rotated_from_mesh(instance, normal_by_tangents(mapped, rotated_to_mesh(instance, normal), instance, index, surface.local));
    }
    //@ end
    return normal_of_map(mapped, normal, mesh_tangents(instance, index));
}

//@ if vertex_tangents & further_uv
// A vertex's tangent along u; 0 where its texture coordinates give none.
fn tangent_of_vertex(index: u32) -> vec3<f32> {
    let words = meshes[index].zw;
    return abs(bitcast<f32>(words.y)) * unit_from_octahedral(words.x);
}

// Returns the vector of a normal map in the frame of the vertices' tangents, in the mesh's space. As in the programs that make the maps,
// neither the normal nor the tangent is normalised first, and the bitangent is their cross product (Mikkelsen, "Simulation of Wrinkled
// Surfaces Revisited", 2008).
fn normal_by_tangents(
    mapped: vec3<f32>,
    otherwise: vec3<f32>,
    instance: Instance,
    index: u32,
    weights: vec3<f32>,
) -> vec3<f32> {
    let face = meshes[index];
    let vertices = face + instance.to_uvs;
    let normal = blend(weights, Corners(
        unit_from_octahedral(meshes[face.x].w),
        unit_from_octahedral(meshes[face.y].w),
        unit_from_octahedral(meshes[face.z].w),
    ));
    let u = blend(weights, Corners(tangent_of_vertex(vertices.x), tangent_of_vertex(vertices.y), tangent_of_vertex(vertices.z)));
    let signs = bitcast<vec3<f32>>(vec3<u32>(meshes[vertices.x].w, meshes[vertices.y].w, meshes[vertices.z].w));
    let v = sign(dot(weights, signs)) * cross(normal, u);
    let result = mapped.x * u + mapped.y * v + mapped.z * normal;
    let length2 = dot(result, result);
    return select(otherwise, result * inverseSqrt(length2), length2 > 0.0);
}
//@ end

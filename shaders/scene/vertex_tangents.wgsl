//@ implements vertex_tangents when vertex_tangents & further_uv
//@ use geometry/triangle
// Tangents of vertices, which smooth meshes have for normal maps.

fn has_tangents(index: u32) -> bool {
    return meshes[meshes[index].x].w != NO_NORMAL;
}

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
    triangle: Triangle,
    weights: vec3<f32>,
) -> vec3<f32> {
    let face = meshes[triangle.face];
    let vertices = face + triangle.instance.to_uvs;
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

//@ without
//@ use geometry/triangle
// Tangents are those of faces.
fn has_tangents(index: u32) -> bool {
    return false;
}

fn normal_by_tangents(
    mapped: vec3<f32>,
    otherwise: vec3<f32>,
    triangle: Triangle,
    weights: vec3<f32>,
) -> vec3<f32> {
    return otherwise;
}

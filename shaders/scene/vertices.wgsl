//@ use bind/meshes
//@ use geometry/triangle
// The colours and the alpha of a mesh's vertices.

fn colour_of_vertex(index: u32) -> vec3<f32> {
    let words = meshes[index].zw;
    // A product with a rounded step is the same on all devices. A quotient is not.
    return (1.0 / 65535.0) * vec3<f32>(vec3<u32>(words.x & 0xffffu, words.x >> 16u, words.y & 0xffffu));
}

// The colour of the vertices at a point of a face.
fn mesh_colour(instance: Instance, index: u32, weights: vec3<f32>) -> vec3<f32> {
    if instance.to_uvs == NO_UVS {
        return vec3<f32>(1.0);
    }
    let face = meshes[index] + instance.to_uvs;
    return blend(weights, Corners(colour_of_vertex(face.x), colour_of_vertex(face.y), colour_of_vertex(face.z)));
}

// Stored as 1 - alpha, so that colours without alpha have the words of those with an alpha of 1.
fn alpha_of_vertex(index: u32) -> f32 {
    return (1.0 / 65535.0) * f32(65535u - (meshes[index].w >> 16u));
}

// The alpha of the vertices at a point of a face.
fn mesh_alpha(instance: Instance, index: u32, weights: vec3<f32>) -> f32 {
    if instance.to_uvs == NO_UVS {
        return 1.0;
    }
    let face = meshes[index] + instance.to_uvs;
    let corners = vec3<f32>(alpha_of_vertex(face.x), alpha_of_vertex(face.y), alpha_of_vertex(face.z));
    return weights.x * corners.x + weights.y * corners.y + weights.z * corners.z;
}

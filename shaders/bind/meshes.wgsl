// The faces, vertices and texture coordinates of all meshes, in one buffer. Indices count its elements, each a vec4:
// - A face holds the indices of its three vertices, counter-clockwise from outside, and its number in the file.
// - A vertex holds its position in the mesh's space and its normal in octahedral form (lib/octahedral).
// - Texture coordinates are u, v, and the colour of the vertex in two words (scene/meshes). Images with other texture coordinates have
//   tables of their own behind these. In the table of a normal map on a smooth mesh, u and v are followed by the tangent, in octahedral
//   form, and by the sign of the bitangent along normal x tangent.
@group(0) @binding(16) var<storage, read> meshes: array<vec4<u32>>;

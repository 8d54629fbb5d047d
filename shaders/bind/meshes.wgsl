// The faces, vertices and texture coordinates of all meshes, in one buffer. Indices count its elements, each a vec4:
// - A face holds the indices of its three vertices, counter-clockwise from outside, and its number in the file.
// - A vertex holds its position in the mesh's space and its normal in octahedral form (lib/octahedral).
// - Texture coordinates are u, v, 0, 0.
@group(0) @binding(16) var<storage, read> meshes: array<vec4<u32>>;

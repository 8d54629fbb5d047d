// The meshes' faces, vertices and texture coordinates in one buffer, in whose words indices count:
// a face is the indices of its vertices, counter-clockwise from outside, and its number in the file;
// a vertex its position in the mesh's space and its normal in the octahedral map (lib/octahedral);
// texture coordinates are u, v, 0, 0.
@group(0) @binding(16) var<storage, read> meshes: array<vec4<u32>>;

//@ use data/texture
@group(0) @binding(10) var<storage, read> textures: array<Texture>;

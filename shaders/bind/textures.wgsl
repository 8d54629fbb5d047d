@group(0) @binding(10) var<${space_of_textures}> textures: array<Texture${size_of_textures}>;

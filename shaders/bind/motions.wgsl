@group(0) @binding(35) var<storage, read> motions: array<vec4<u32>>;

// The texels of all images, linear, row 0 on top: three 32-bit floats per texel.
@group(0) @binding(12) var<storage, read> texels: array<f32>;

// Texels of all images, linear: three 32-bit floats each, row 0 on top.
@group(0) @binding(12) var<storage, read> texels: array<f32>;

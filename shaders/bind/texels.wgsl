// The texels of all images, row 0 on top, in words that the files of shaders/texel read. Where an image has sRGB codes, a table of
// their 256 linear values comes first.
@group(0) @binding(12) var<storage, read> texels: array<u32>;

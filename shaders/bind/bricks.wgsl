// The grids of all media: their tables, and texels of 16 bits, two to a word (medium/grid).
@group(0) @binding(39) var<storage, read> bricks: array<u32>;

//@ use data/primitive
@group(0) @binding(7) var<storage, read> quads: array<Quad>;

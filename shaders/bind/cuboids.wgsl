//@ use data/primitive
@group(0) @binding(8) var<storage, read> cuboids: array<Cuboid>;

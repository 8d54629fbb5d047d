//@ use data/primitive
@group(0) @binding(8) var<${space_of_cuboids}> cuboids: array<Cuboid${size_of_cuboids}>;

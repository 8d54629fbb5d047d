//@ use data/primitive
@group(0) @binding(32) var<${space_of_disks}> disks: array<Quad${size_of_disks}>;

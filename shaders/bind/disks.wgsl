//@ use data/primitive
@group(0) @binding(21) var<${space_of_disks}> disks: array<Quad${size_of_disks}>;

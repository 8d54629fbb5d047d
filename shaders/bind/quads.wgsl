//@ use data/primitive
@group(0) @binding(7) var<${space_of_quads}> quads: array<Quad${size_of_quads}>;

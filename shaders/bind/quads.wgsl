@group(0) @binding(7) var<${space_of_quads}> quads: array<Quad${size_of_quads}>;

fn quad_at(index: u32, instance: u32) -> Quad {
    return quads[index];
}

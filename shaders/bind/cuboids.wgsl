@group(0) @binding(8) var<${space_of_cuboids}> cuboids: array<Cuboid${size_of_cuboids}>;

fn cuboid_at(index: u32, instance: u32) -> Cuboid {
    return cuboids[index];
}

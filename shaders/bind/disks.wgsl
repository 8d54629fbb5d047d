@group(0) @binding(32) var<${space_of_disks}> disks: array<Quad${size_of_disks}>;

fn disk_at(index: u32, instance: u32) -> Quad {
    return disks[index];
}

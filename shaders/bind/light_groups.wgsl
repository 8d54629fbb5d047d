// The group of each light without size, then that of each row of the table of materials.
@group(0) @binding(37) var<storage, read> light_groups: array<u32>;

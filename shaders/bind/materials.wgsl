//@ use data/material
@group(0) @binding(9) var<storage, read> materials: array<Material>;

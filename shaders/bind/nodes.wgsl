//@ use data/primitive
@group(0) @binding(5) var<storage, read> nodes: array<Node>;

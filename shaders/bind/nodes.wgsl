@group(0) @binding(5) var<${space_of_nodes}> nodes: array<Node${size_of_nodes}>;

@group(0) @binding(24) var<${space_of_light_nodes}> light_nodes: array<LightNode${size_of_light_nodes}>;

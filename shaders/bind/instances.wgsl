@group(0) @binding(15) var<${space_of_instances}> instances: array<Instance${size_of_instances}>;

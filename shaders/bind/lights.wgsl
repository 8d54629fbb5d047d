@group(0) @binding(18) var<${space_of_lights}> lights: array<Light${size_of_lights}>;

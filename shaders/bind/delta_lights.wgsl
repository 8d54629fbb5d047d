@group(0) @binding(28) var<${space_of_delta_lights}> delta_lights: array<DeltaLight${size_of_delta_lights}>;

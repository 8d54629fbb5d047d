@group(0) @binding(9) var<${space_of_materials}> materials: array<Material${size_of_materials}>;

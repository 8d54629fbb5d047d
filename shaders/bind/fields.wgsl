@group(0) @binding(38) var<${space_of_fields}> fields: array<ScalarField${size_of_fields}>;

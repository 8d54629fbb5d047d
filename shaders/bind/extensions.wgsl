// The further rows of each material.
@group(0) @binding(29) var<storage, read> extensions: array<Rows>;

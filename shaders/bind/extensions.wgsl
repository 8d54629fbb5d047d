//@ use data/material
// What each material has beside its row of the table.
@group(0) @binding(29) var<storage, read> extensions: array<Extension>;

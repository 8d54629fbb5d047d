//@ use data/window
@group(0) @binding(3) var<storage, read_write> records: array<RunRecord>;

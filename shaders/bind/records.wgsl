@group(0) @binding(23) var<storage, read_write> records: array<RunRecord>;

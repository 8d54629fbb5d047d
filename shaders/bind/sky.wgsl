@group(0) @binding(19) var<storage, read> sky: array<u32>;

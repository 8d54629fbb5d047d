@group(0) @binding(26) var<storage, read_write> answers: array<Answer>;

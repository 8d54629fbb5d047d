// Of the same state what fills no vec4.
@group(0) @binding(27) var<storage, read_write> path_words: array<u32>;

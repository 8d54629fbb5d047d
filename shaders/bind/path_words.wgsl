// The fields of the paths' state that fill no vec4 (slots/state).
@group(0) @binding(27) var<storage, read_write> path_words: array<u32>;

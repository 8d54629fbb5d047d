//@ use data/texture
@group(0) @binding(11) var<storage, read> frames: array<Frame>;

//@ use truth/word
//@ use step/start
// Where the sample is, from its pixel's left upper corner, in pixels: x to the right, y down.
fn offset0_of(path: ptr<function, Path>) -> vec2<u32> {
    let offset = pixel_offset(path).xy;
    return vec2<u32>(word_of(offset.x), word_of(offset.y));
}

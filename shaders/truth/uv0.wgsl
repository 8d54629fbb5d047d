//@ use truth/word
//@ use choice/uv_of_hit
// The texture coordinates at the hit.
fn uv0_of(path: ptr<function, Path>) -> vec2<u32> {
    if !has_hit(path) {
        return vec2<u32>(0u);
    }
    let uv = uv_of_hit(path);
    return vec2<u32>(word_of(uv.x), word_of(uv.y));
}

// Wrong on purpose: every bit is flipped alike, whatever the bits below it: a random shift keeps the nets, and keeps the order of
// the points too, so that blocks are not padded.
fn nested_permutation(words: vec4<u32>, seeds: vec4<u32>) -> vec4<u32> {
    return words ^ seeds;
}

// Wrong on purpose: high bits decide on low ones, so that points leave their intervals.
fn nested_permutation(words: vec4<u32>, seeds: vec4<u32>) -> vec4<u32> {
    var v = (words ^ seeds) * 0x9e3779b1u;
    v ^= v >> vec4<u32>(15u);
    return v * 0x85ebca6bu;
}

// Wrong on purpose: the scrambles are a few of all, since no more of a seed than its lowest bits is used.
fn nested_permutation(words: vec4<u32>, seeds: vec4<u32>) -> vec4<u32> {
    let few = seeds & vec4<u32>(7u);
    return (words ^ (words * 0xab13244eu)) * (2u * few + 1u) + few;
}

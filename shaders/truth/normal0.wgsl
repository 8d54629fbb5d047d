//@ use truth/word
//@ use choice/normal_of_hit
// The shading normal at the hit, with the normal map, on the side from which the ray comes.
fn normal0_of(path: ptr<function, Path>) -> vec3<u32> {
    if !has_hit(path) {
        return vec3<u32>(0u);
    }
    return words_of(normal_of_hit(path));
}

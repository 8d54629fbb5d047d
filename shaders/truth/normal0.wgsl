//@ implements normal0 when truth & surface
//@ use truth/word
//@ use choice/evaluation
//@ use choice/normal_map
//@ use scene/surfaces
//@ use scene/interaction
// The shading normal at the hit, with the normal map, on the side from which the ray comes.
fn normal0_of(path: ptr<function, Path>) -> vec3<u32> {
    if !has_hit(path) {
        return vec3<u32>(0u);
    }
    let ray = (*path).ray;
    let hit = path_hit(path);
    let surface = surface_at(hit, ray);
    let frame = shading_frame(hit, surface, ray.direction);
    let code = evaluate_material(hit, surface, frame.front).normal;
    return words_of(mapped_normal(hit, surface, ray.direction, frame.shading, frame.front, code));
}

//@ without
// There is no surface to hit.
fn normal0_of(path: ptr<function, Path>) -> vec3<u32> {
    return vec3<u32>(0u);
}

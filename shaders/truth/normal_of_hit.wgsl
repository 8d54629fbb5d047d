//@ implements normal_of_hit when surface
//@ use choice/evaluation
//@ use choice/normal_map
//@ use scene/surfaces
//@ use scene/interaction
// The shading normal where a path has hit a surface.
fn normal_of_hit(path: ptr<function, Path>) -> vec3<f32> {
    let ray = (*path).ray;
    let hit = path_hit(path);
    let surface = surface_at(hit, ray);
    let frame = shading_frame(hit, surface, ray.direction);
    let code = evaluate_material(hit, surface, frame.front).normal;
    return mapped_normal(hit, surface, ray.direction, frame.shading, frame.front, code);
}

//@ without
// There is no surface to hit.
fn normal_of_hit(path: ptr<function, Path>) -> vec3<f32> {
    return vec3<f32>(0.0);
}

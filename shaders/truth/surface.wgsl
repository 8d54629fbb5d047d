//@ implements surface0 when surface
//@ use bind/frames
//@ use truth/word
//@ use choice/evaluation
//@ use choice/faces
//@ use choice/normal_map
//@ use choice/uv
//@ use scene/interaction
//@ use scene/primitives
//@ use scene/surfaces
// The surface that a camera ray hits: 0 without a hit.

// The shading normal, with the normal map, on the side from which the ray comes.
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

// The texture coordinates. The first frames of the table are those of the objects by their numbers.
fn uv0_of(path: ptr<function, Path>) -> vec2<u32> {
    if !has_hit(path) {
        return vec2<u32>(0u);
    }
    let hit = path_hit(path);
    let local = surface_at(hit, (*path).ray).local;
    let frame = frames[primitive_order(hit)];
    return words_of(vec3<f32>(surface_uv(hit, frame.origin + along_frame(frame, local), local).uv, 0.0)).xy;
}

// The number of a mesh's face, from 1 in the order of its file.
fn face0_of(path: ptr<function, Path>) -> u32 {
    if !has_hit(path) || primitive_kind((*path).status) != KIND_TRIANGLE {
        return 0u;
    }
    return part_number(path_hit(path)) + 1u;
}

// The number of the object, from 1.
fn object0_of(path: ptr<function, Path>) -> u32 {
    if !has_hit(path) {
        return 0u;
    }
    return primitive_order(path_hit(path)) + 1u;
}

//@ without
// There is no surface to hit.
fn normal0_of(path: ptr<function, Path>) -> vec3<u32> {
    return vec3<u32>(0u);
}

fn uv0_of(path: ptr<function, Path>) -> vec2<u32> {
    return vec2<u32>(0u);
}

fn face0_of(path: ptr<function, Path>) -> u32 {
    return 0u;
}

fn object0_of(path: ptr<function, Path>) -> u32 {
    return 0u;
}

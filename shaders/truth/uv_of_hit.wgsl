//@ implements uv_of_hit when truth.uv & surface
//@ use bind/frames
//@ use scene/surfaces
//@ use scene/primitives
//@ use choice/uv
// The texture coordinates where a path has hit a surface. The first frames of the table are those of the objects by their numbers.
fn uv_of_hit(path: ptr<function, Path>) -> vec2<f32> {
    let hit = path_hit(path);
    let surface = surface_at(hit, (*path).ray);
    let frame = frames[primitive_order(hit)];
    return surface_uv(hit, frame.origin + along_frame(frame, surface.local), surface.local).uv;
}

//@ without
// There is no surface to hit.
fn uv_of_hit(path: ptr<function, Path>) -> vec2<f32> {
    return vec2<f32>(0.0);
}

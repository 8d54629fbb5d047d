//@ implements uv0 when truth & surface
//@ use bind/frames
//@ use truth/word
//@ use scene/textures
//@ use scene/surfaces
//@ use scene/primitives
//@ use choice/uv
// The texture coordinates at the hit. The first frames of the table are those of the objects by their numbers.
fn uv0_of(path: ptr<function, Path>) -> vec2<u32> {
    if !has_hit(path) {
        return vec2<u32>(0u);
    }
    let hit = path_hit(path);
    let surface = surface_at(hit, (*path).ray);
    let frame = frames[primitive_order(hit)];
    let uv = surface_uv(hit, frame.origin + along_frame(frame, surface.local), surface.local).uv;
    return vec2<u32>(word_of(uv.x), word_of(uv.y));
}

//@ without
// There is no surface to hit.
fn uv0_of(path: ptr<function, Path>) -> vec2<u32> {
    return vec2<u32>(0u);
}

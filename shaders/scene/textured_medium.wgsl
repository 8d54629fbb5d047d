//@ alternative medium_albedo when textured_medium
//@ use scene/textures
//@ use choice/moved_medium
// The albedo of a medium at a point of render space: its own, or that of its texture, evaluated in the medium's space. A volume
// has no texture coordinates, so scenes with an image texture there are refused when they are read.
fn medium_albedo(medium: Medium, point: vec3<f32>) -> vec3<f32> {
    if medium.texture == NO_TEXTURE {
        return medium.colour;
    }
    let frame = frames[medium.frame];
    let offset = along_frame(frame, offset_at_rest(medium, point));
    return texture_colour(medium.texture, frame, offset, SurfaceUv(vec2<f32>(0.0), vec2<bool>(false)));
}

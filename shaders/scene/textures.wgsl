//@ use bind/textures
//@ use bind/frames
//@ each texture
//@ use texture/${name}
//@ end
// The colour of a texture at an offset from its frame's origin; only the kinds of texture that the scene has.
fn texture_colour(index: u32, frame: Frame, offset: vec3<f32>, uv: SurfaceUv) -> vec3<f32> {
    let at = TexturePoint(frame.origin + offset, offset.z, frame.phase, uv.uv, uv.wraps);
    let texture = textures[index];
    switch texture.kind {
        //@ each texture
        ${case}: {
            return ${name}_colour(texture, at);
        }
        //@ end
    }
}

//@ use data/hit
//@ use data/material
//@ use data/texture
//@ use bind/textures
//@ use bind/frames
//@ use choice/uv
//@ each texture
//@ use texture/${name}
//@ end
// The colour of a surface: the material's own, or that of its texture at the point in the object's space.
fn surface_colour(material: Material, code: u32, surface: Surface) -> vec3<f32> {
    if material.texture == NO_TEXTURE {
        return material.colour;
    }
    let frame = frames[surface.frame];
    let offset = along_frame(frame, surface.local);
    let point = frame.origin + offset;
    let uv = surface_uv(code, point, surface.local);
    let place = TexturePoint(point, offset.z, frame.phase, uv.uv, uv.wraps);
    let texture = textures[material.texture];
    switch texture.kind {
        //@ each texture
        ${case}: {
            return ${name}_colour(texture, place);
        }
        //@ end
    }
}

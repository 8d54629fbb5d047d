//@ alternative colour when texture
//@ use scene/textures
//@ use choice/uv_tables
//@ use choice/faces
// The colour of a surface at a hit: the material's own, or that of its texture, evaluated in the object's space.
fn surface_colour(material: Material, hit: Hit, surface: Surface) -> vec3<f32> {
    if material.texture == NO_TEXTURE {
        return material.colour;
    }
    let frame = frames[surface.frame];
    let offset = along_frame(frame, point_in_object(hit, surface.local));
    let uv = uv_in_table(frame.phase, hit, frame.origin + offset, surface.local);
    return texture_colour(material.texture, frame, offset, uv);
}

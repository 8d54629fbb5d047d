//@ alternative colour when texture
//@ use data/surface
//@ use data/hit
//@ use data/material
//@ use data/primitive
//@ use scene/textures
//@ use choice/uv
//@ if mesh
//@ use scene/meshes
//@ end
//@ if further_uv
//@ use scene/uv_tables
//@ end
// The colour of a surface at a hit: the material's own, or that of its texture, evaluated in the object's space.
fn surface_colour(material: Material, hit: Hit, surface: Surface) -> vec3<f32> {
    if material.texture == NO_TEXTURE {
        return material.colour;
    }
    let frame = frames[surface.frame];
    var local = surface.local;
    //@ if mesh
    if primitive_kind(hit.code) == KIND_TRIANGLE {
        local = mesh_point(primitive_index(hit.code), local);
    }
    //@ end
    let offset = along_frame(frame, local);
    //@ if further_uv
    let uv = uv_in_table(frame.phase, hit, frame.origin + offset, surface.local);
    //@ else
    let uv = surface_uv(hit, frame.origin + offset, surface.local);
    //@ end
    return texture_colour(material.texture, frame, offset, uv);
}

//@ use data/hit
//@ use data/material
// The colour of a surface of a scene without textures.
fn surface_colour(material: Material, code: u32, instance: u32, surface: Surface) -> vec3<f32> {
    return material.colour;
}

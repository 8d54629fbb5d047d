//@ alternative colour when !texture
//@ use data/surface
//@ use data/hit
//@ use data/material
// The colour of a surface in a scene without textures.
fn surface_colour(material: Material, hit: Hit, surface: Surface) -> vec3<f32> {
    return material.colour;
}

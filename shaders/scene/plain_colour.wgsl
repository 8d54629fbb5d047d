//@ alternative colour when !texture
// The colour of a surface in a scene without textures.
fn surface_colour(material: Material, hit: Hit, surface: Surface) -> vec3<f32> {
    return material.colour;
}

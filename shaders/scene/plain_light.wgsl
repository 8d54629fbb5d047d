//@ implements light_colour when !textured_light
// The radiance of a light without a texture.
fn colour_of_light(row: Material, hit: Hit, surface: Surface) -> vec3<f32> {
    return row.colour;
}

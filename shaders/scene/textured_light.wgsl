//@ implements light_colour when textured_light
//@ use choice/colour
// The radiance of a light, which may have a texture.
fn colour_of_light(row: Material, hit: Hit, surface: Surface) -> vec3<f32> {
    return surface_colour(row, hit, surface);
}

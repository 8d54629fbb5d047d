//@ use bind/settings
//@ use choice/axes
//@ use lib/sphere_map
//@ use scene/texel
// The radiance of a ray that leaves the scene: a latitude-longitude image. Its texels come first in the table of texels.
fn image_background(direction: vec3<f32>) -> vec3<f32> {
    let at = sky_place(to_world(direction));
    return settings.background_bottom
        * image_at(0u, settings.background_width, settings.background_height, at.x, at.y, true);
}

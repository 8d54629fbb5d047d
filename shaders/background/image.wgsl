//@ use bind/settings
//@ use choice/axes
//@ use scene/texel
// The radiance of a ray that leaves the scene: a latitude-longitude image.
fn image_background(direction: vec3<f32>) -> vec3<f32> {
    let at = sky_uv(to_world(direction));
    let image = ImageLayout(
        settings.background_texel, settings.background_width, settings.background_height, settings.background_format,
    );
    return settings.background_bottom * image_at(image, at.x, at.y, vec2<bool>(true, false));
}

//@ use bind/settings
//@ use choice/axes
//@ use scene/texel
// The radiance of a ray that leaves the scene: a square whose texels have one solid angle, and one radiance each, as in pbrt-v4.
fn octahedral_background(direction: vec3<f32>) -> vec3<f32> {
    let side = settings.background_width;
    let at = min(vec2<u32>(f32(side) * square_map(to_world(direction))), vec2<u32>(side - 1u));
    let image = ImageLayout(settings.background_texel, side, side, settings.background_format);
    return settings.background_bottom * texel(image, at.x, at.y);
}

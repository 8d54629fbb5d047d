//@ use choice/number_texels
// An image. u goes right and v goes up. It is bilinear between texel centres and constant beyond the outermost ones, except
// where the texture coordinates wrap: there the image continues at its other edge.
fn image_colour(texture: Texture, at: TexturePoint) -> vec3<f32> {
    let image = ImageLayout(texture.texel, texture.width, texture.height, texture.format);
    let is_number = texture.parameter != 0.0;
    return texture.first * colour_or_number_at(image, at.uv.x, 1.0 - at.uv.y, at.wraps, is_number);
}

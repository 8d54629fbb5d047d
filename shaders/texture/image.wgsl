//@ use data/texture
//@ use scene/texel
// An image, u to the right and v up, bilinear between texel centres, held at its edges; around a sphere the right edge
// meets the left.
fn image_colour(texture: Texture, place: TexturePoint) -> vec3<f32> {
    return texture.first
        * image_at(texture.texel, texture.width, texture.height, place.uv.x, 1.0 - place.uv.y, place.wraps);
}

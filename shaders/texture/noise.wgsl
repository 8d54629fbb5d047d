// Perlin noise as a grey of 0.5 (1 + perlin(scale p)). The point is already scaled and reduced modulo 256, the period of the noise.
fn noise_colour(texture: Texture, at: TexturePoint) -> vec3<f32> {
    return texture.first * clamp(0.5 * (1.0 + perlin(at.point)), 0.0, 1.0);
}

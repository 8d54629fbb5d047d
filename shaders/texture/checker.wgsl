// A solid checker. The parity of the sum of the cell's coordinates chooses between the even and the odd colour. The point is
// already divided by the scale and reduced modulo 2, which preserves the parity.
fn checker_colour(texture: Texture, at: TexturePoint) -> vec3<f32> {
    let cell = vec3<i32>(floor(at.point));
    return select(texture.second, texture.first, ((cell.x + cell.y + cell.z) & 1) == 0);
}

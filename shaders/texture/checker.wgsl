//@ use data/texture
// A solid checker: even and odd by the parity of the sum of the cell's coordinates. The point comes divided by the scale
// and reduced modulo 2, which keeps the parity.
fn checker_colour(texture: Texture, place: TexturePoint) -> vec3<f32> {
    let cell = vec3<i32>(floor(place.point));
    return select(texture.second, texture.first, ((cell.x + cell.y + cell.z) & 1) == 0);
}

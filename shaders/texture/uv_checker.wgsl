// Squares of two colours in texture coordinates. `parameter` is 1 over their side.
fn uv_checker_colour(texture: Texture, at: TexturePoint) -> vec3<f32> {
    let cell = vec2<i32>(floor(texture.parameter * at.uv));
    return select(texture.second, texture.first, ((cell.x + cell.y) & 1) == 0);
}

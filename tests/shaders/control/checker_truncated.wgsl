// Wrong on purpose: cells by truncation, which makes the two around zero one.
fn checker_colour(texture: Texture, at: TexturePoint) -> vec3<f32> {
    let cell = vec3<i32>(at.point);
    return select(texture.second, texture.first, ((cell.x + cell.y + cell.z) & 1) == 0);
}

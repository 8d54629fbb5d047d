// Wrong on purpose: the turn in one part, whose multiples round.
fn marble_colour(texture: Texture, at: TexturePoint) -> vec3<f32> {
    let angle = texture.parameter * at.along_z + at.phase + 10.0 * turbulence(at.point);
    return texture.first * (0.5 * (1.0 + sin(within_one_turn(angle))));
}

fn within_one_turn(angle: f32) -> f32 {
    return angle - round(angle * 0.15915494) * 6.2831855;
}

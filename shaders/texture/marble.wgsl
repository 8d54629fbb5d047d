// Stripes along the object's z, bent by turbulence: 0.5 (1 + sin(scale z + 10 turbulence(p))).
fn marble_colour(texture: Texture, at: TexturePoint) -> vec3<f32> {
    let angle = texture.parameter * at.along_z + at.phase + 10.0 * turbulence(at.point);
    return texture.first * (0.5 * (1.0 + circle_point(within_one_turn(angle) * 0.15915494).y));
}

// The angle minus a multiple of 2 pi, in [-pi, pi]. A turn is split into two parts, and the first is short enough that its multiples
// are exact (Cody and Waite, "Software Manual for the Elementary Functions", 1980).
fn within_one_turn(angle: f32) -> f32 {
    let turns = round(angle * 0.15915494);
    return (angle - turns * 6.28125) - turns * 0.0019353072;
}

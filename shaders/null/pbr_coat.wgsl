//@ use data/material
// No material of glTF has a coat.
fn coat_spreads(lobes: Lobes, under: bool) -> bool {
    return under;
}

fn emission_under_coat(emission: vec3<f32>, hit: Interaction) -> vec3<f32> {
    return emission;
}

fn draw_coat(draw: LobeDraw, hit: Interaction, u: vec2<f32>, under: f32) -> LobeDraw {
    return draw;
}

fn with_coat(under: Response, hit: Interaction, direction: vec3<f32>, albedo: f32) -> Response {
    return under;
}

fn coat_is_reversible(hit: Interaction, reverse: Interaction) -> bool {
    return true;
}

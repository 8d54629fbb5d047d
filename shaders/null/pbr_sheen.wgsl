//@ use data/material
// No material of glTF has a sheen.
fn sheen_spreads(lobes: Lobes, under: bool) -> bool {
    return under;
}

fn below_sheen(scatter: Scatter, hit: Interaction, outer: LobeDraw) -> Scatter {
    return scatter;
}

fn sheened_albedo(hit: Interaction, under: f32) -> f32 {
    return under;
}

fn draw_sheen(draw: LobeDraw, hit: Interaction, u: vec2<f32>, under: f32) -> LobeDraw {
    return draw;
}

fn with_sheen(under: Response, hit: Interaction, direction: vec3<f32>, albedo: f32) -> Response {
    return under;
}

//@ use data/material
// No material of glTF has a share of glass.
fn transmission_spreads(material: Material, lobes: Lobes, base: bool) -> bool {
    return base;
}

fn transmission_albedo(material: Material, hit: Interaction, base: f32) -> f32 {
    return base;
}

fn draw_transmission(draw: LobeDraw, material: Material, hit: Interaction, u: vec2<f32>, base: f32) -> LobeDraw {
    return draw;
}

fn with_transmission(base: Response, material: Material, hit: Interaction, direction: vec3<f32>, base_albedo: f32) -> Response {
    return base;
}

//@ use data/hit
//@ use data/material
//@ use data/surface
//@ use geometry/offset
//@ use choice/shading
//@ use scene/responses
// On a smooth mesh, the two sides of a facet have two points. A material that responds on both chooses one of them before it aims at a
// light. The other side is never aimed at. Light sampling has half of its density on the chosen one, which is the same to MIS as
// twice the density of the material.

fn choose_side(
    samples_lights: bool,
    material: Material,
    point: vec3<f32>,
    hit: Hit,
    surface: Surface,
    facing: vec3<f32>,
    u: f32,
) -> LightSide {
    let chooses = samples_lights && responds_on_both_sides(material) && is_smooth(hit.code);
    let below = chooses && u < 0.5;
    let facet_point = leave_surface(surface.point, surface.error, -facing, -facing);
    return LightSide(select(point, facet_point, below), chooses, below);
}

// The response to a light in a direction from the chosen side, and the density of the drawn direction.
fn respond_on_side(sampled: LightResponse, side: LightSide, direction: vec3<f32>, shading: vec3<f32>) -> LightResponse {
    var own = sampled;
    if side.is_chosen {
        let is_aimed_at = (dot(direction, shading) < 0.0) == side.is_below;
        own.probed = select(0.0, 2.0, is_aimed_at);
        own.response.value *= own.probed;
        own.response.pdf *= 2.0;
        own.drawn_pdf *= 2.0;
    }
    return own;
}

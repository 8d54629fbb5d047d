//@ implements both_sides when both_sides
//@ use geometry/offset
//@ use choice/shading
//@ use scene/responses
// On a smooth mesh, an event has one point on each side of the facet. A material that responds on both sides chooses one of them, with
// probability 1/2, and samples a light from there. To MIS, half the density of light sampling is the same as twice the density of the
// material.

// The number of points from which an event samples lights. It takes one of them.
fn points_of_event(evaluated: EvaluatedMaterial, hit: Hit) -> f32 {
    return select(1.0, 2.0, responds_on_both_sides(evaluated) && is_smooth(hit.code));
}

fn choose_side(
    samples_lights: bool,
    evaluated: EvaluatedMaterial,
    point: vec3<f32>,
    hit: Hit,
    surface: Surface,
    facing: vec3<f32>,
    u: f32,
) -> LightSide {
    let chooses = samples_lights && points_of_event(evaluated, hit) > 1.0;
    let below = chooses && u < 0.5;
    let facet_point = leave_surface(surface.point, surface.error, -facing, -facing);
    return LightSide(select(point, facet_point, below), chooses, below);
}

// Returns the response to a sampled light, and the densities, for the chosen side: light on the other side does not count.
fn respond_on_side(sampled: LightResponse, side: LightSide, direction: vec3<f32>, shading: vec3<f32>) -> LightResponse {
    var chosen = sampled;
    if side.is_chosen {
        let is_on_side = (dot(direction, shading) < 0.0) == side.is_below;
        chosen.probed = select(0.0, 2.0, is_on_side);
        chosen.response.value *= chosen.probed;
        chosen.response.pdf *= 2.0;
        chosen.drawn_pdf *= 2.0;
    }
    return chosen;
}

//@ without
// The sides of no surface have points of their own.
fn points_of_event(evaluated: EvaluatedMaterial, hit: Hit) -> f32 {
    return 1.0;
}

fn choose_side(
    samples_lights: bool,
    evaluated: EvaluatedMaterial,
    point: vec3<f32>,
    hit: Hit,
    surface: Surface,
    facing: vec3<f32>,
    u: f32,
) -> LightSide {
    return LightSide(point, false, false);
}

fn respond_on_side(sampled: LightResponse, side: LightSide, direction: vec3<f32>, shading: vec3<f32>) -> LightResponse {
    return sampled;
}

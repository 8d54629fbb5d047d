//@ use light/parts
//@ use light/quad
// Parts of a quad: smaller parallelograms.

fn part_of_quad(quad: Quad, part: u32) -> Quad {
    let cell = cell_of_part(part);
    var piece = quad;
    piece.corner += cell.low.x * quad.u + cell.low.y * quad.v;
    piece.u *= cell.size.x;
    piece.v *= cell.size.y;
    return piece;
}

fn quad_part_sample(from_point: vec3<f32>, quad: Quad, part: u32, u: vec2<f32>) -> DirectionSample {
    return quad_light_sample(from_point, part_of_quad(quad, part), u);
}

fn quad_part_pdf(from_point: vec3<f32>, direction: vec3<f32>, quad: Quad, part: u32) -> f32 {
    return quad_light_pdf(from_point, direction, part_of_quad(quad, part));
}

fn quad_part_point(quad: Quad, part: u32, u: vec2<f32>) -> LightPoint {
    return quad_light_point(part_of_quad(quad, part), u);
}

fn quad_part_coordinates(local: vec3<f32>) -> vec2<f32> {
    return local.xy;
}

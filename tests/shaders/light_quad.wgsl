//@ use light/quad
//@ use geometry/quad
// A quad behind the names that test/light calls.
fn shape_sample(from_point: vec3<f32>, shape: Quad, u: vec2<f32>) -> DirectionSample {
    return quad_light_sample(from_point, shape, u);
}

fn shape_pdf(from_point: vec3<f32>, direction: vec3<f32>, shape: Quad) -> f32 {
    return quad_light_pdf(from_point, direction, shape);
}

fn shape_distance(ray: Ray, shape: Quad) -> f32 {
    return quad_distance(ray, shape);
}

//@ use light/quad_parts
//@ use geometry/quad
// A part of a quad behind the names that test/light calls. The quad's `light` is the part.
fn shape_sample(from_point: vec3<f32>, shape: Quad, u: vec2<f32>) -> DirectionSample {
    return quad_part_sample(from_point, shape, shape.light, u);
}

fn shape_pdf(from_point: vec3<f32>, direction: vec3<f32>, shape: Quad) -> f32 {
    return quad_part_pdf(from_point, direction, shape, shape.light);
}

fn shape_distance(ray: Ray, shape: Quad) -> f32 {
    return quad_distance(ray, shape);
}

//@ use light/triangle
// A triangle behind the names that test/light calls.
fn shape_sample(from_point: vec3<f32>, shape: Corners, u: vec2<f32>) -> DirectionSample {
    return corners_sample(from_point, shape, u);
}

fn shape_pdf(from_point: vec3<f32>, direction: vec3<f32>, shape: Corners) -> f32 {
    return corners_pdf(from_point, shape);
}

fn shape_distance(ray: Ray, shape: Corners) -> f32 {
    return face_hit(ray, shape).t;
}

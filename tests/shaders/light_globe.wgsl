//@ use light/globe
//@ use geometry/globe
// A globe behind the names that test/light calls.
fn shape_sample(from_point: vec3<f32>, shape: Globe, u: vec2<f32>) -> DirectionSample {
    return globe_light_sample(from_point, shape, u);
}

fn shape_pdf(from_point: vec3<f32>, direction: vec3<f32>, shape: Globe) -> f32 {
    return globe_light_pdf(from_point, direction, shape);
}

fn shape_distance(ray: Ray, shape: Globe) -> f32 {
    return globe_distance(ray, shape);
}

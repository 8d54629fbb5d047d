//@ use light/sphere
//@ use geometry/sphere
// A sphere behind the names that test/light calls.
fn shape_sample(from_point: vec3<f32>, shape: Sphere, u: vec2<f32>) -> DirectionSample {
    return sphere_light_sample(from_point, shape, u);
}

fn shape_pdf(from_point: vec3<f32>, direction: vec3<f32>, shape: Sphere) -> f32 {
    return sphere_light_pdf(from_point, direction, shape);
}

fn shape_distance(ray: Ray, shape: Sphere) -> f32 {
    return sphere_distance(ray, shape);
}

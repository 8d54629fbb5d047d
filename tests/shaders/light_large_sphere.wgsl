//@ use light/large_sphere
//@ use geometry/large_sphere
// A large sphere behind the names that test/light calls.
fn shape_sample(from_point: vec3<f32>, shape: LargeSphere, u: vec2<f32>) -> DirectionSample {
    return large_sphere_light_sample(from_point, shape, u);
}

fn shape_pdf(from_point: vec3<f32>, direction: vec3<f32>, shape: LargeSphere) -> f32 {
    return large_sphere_light_pdf(from_point, direction, shape);
}

fn shape_distance(ray: Ray, shape: LargeSphere) -> f32 {
    return large_sphere_distance(ray, shape);
}

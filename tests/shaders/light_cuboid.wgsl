//@ use light/cuboid
//@ use geometry/cuboid
// A cuboid behind the names that test/light calls.
fn shape_sample(from_point: vec3<f32>, shape: Cuboid, u: vec2<f32>) -> DirectionSample {
    return cuboid_light_sample(from_point, shape, u);
}

fn shape_pdf(from_point: vec3<f32>, direction: vec3<f32>, shape: Cuboid) -> f32 {
    return cuboid_light_pdf(from_point, direction, shape);
}

fn shape_distance(ray: Ray, shape: Cuboid) -> f32 {
    return cuboid_distance(ray, shape);
}

//@ use light/disk
//@ use geometry/disk
// A disk behind the names that test/light calls.
fn shape_sample(from_point: vec3<f32>, shape: Quad, u: vec2<f32>) -> DirectionSample {
    return disk_light_sample(from_point, shape, u);
}

fn shape_pdf(from_point: vec3<f32>, direction: vec3<f32>, shape: Quad) -> f32 {
    return disk_light_pdf(from_point, direction, shape);
}

fn shape_distance(ray: Ray, shape: Quad) -> f32 {
    return disk_distance(ray, shape);
}

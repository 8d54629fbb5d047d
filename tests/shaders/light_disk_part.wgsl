//@ use light/disk_parts
//@ use geometry/disk
// A part of a disk behind the names that test/light calls. The disk's `light` is the part.
fn shape_sample(from_point: vec3<f32>, shape: Quad, u: vec2<f32>) -> DirectionSample {
    return disk_part_sample(from_point, shape, shape.light, u);
}

fn shape_pdf(from_point: vec3<f32>, direction: vec3<f32>, shape: Quad) -> f32 {
    return disk_part_pdf(from_point, direction, shape, shape.light);
}

fn shape_distance(ray: Ray, shape: Quad) -> f32 {
    return disk_distance(ray, shape);
}

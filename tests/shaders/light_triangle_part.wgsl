//@ use light/triangle_parts
// A part of a triangle behind the names that test/light calls.
struct TrianglePart {
    a: vec3<f32>,
    part: u32,
    b: vec3<f32>,
    c: vec3<f32>,
}

fn shape_sample(from_point: vec3<f32>, shape: TrianglePart, u: vec2<f32>) -> DirectionSample {
    return corners_sample(from_point, part_of_triangle(Corners(shape.a, shape.b, shape.c), shape.part), u);
}

fn shape_pdf(from_point: vec3<f32>, direction: vec3<f32>, shape: TrianglePart) -> f32 {
    return corners_pdf(from_point, part_of_triangle(Corners(shape.a, shape.b, shape.c), shape.part));
}

fn shape_distance(ray: Ray, shape: TrianglePart) -> f32 {
    return face_hit(ray, Corners(shape.a, shape.b, shape.c)).t;
}

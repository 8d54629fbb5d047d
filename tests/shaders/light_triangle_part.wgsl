//@ use light/triangle
//@ use scene/face_parts
//@ use geometry/slab
// A part of a triangle behind the names that test/light calls.
struct TrianglePart {
    a: vec3<f32>,
    part: u32,
    b: vec3<f32>,
    c: vec3<f32>,
}

fn shape_sample(from_point: vec3<f32>, shape: TrianglePart, u: vec2<f32>) -> DirectionSample {
    let corners = part_of_triangle(Corners(shape.a, shape.b, shape.c), shape.part);
    return triangle_light_sample(from_point, corners.a, corners.b, corners.c, u);
}

fn shape_pdf(from_point: vec3<f32>, direction: vec3<f32>, shape: TrianglePart) -> f32 {
    let corners = part_of_triangle(Corners(shape.a, shape.b, shape.c), shape.part);
    return triangle_light_pdf(from_point, direction, corners.a, corners.b, corners.c);
}

fn shape_distance(ray: Ray, shape: TrianglePart) -> f32 {
    return triangle_hit(shear_along(ray, slab_inverse(ray.direction)), shape.a, shape.b, shape.c).t;
}

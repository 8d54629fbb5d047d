//@ use light/triangle
//@ use geometry/triangle
//@ use geometry/slab
// A triangle behind the names that test/light calls.
struct Triangle {
    a: vec3<f32>,
    b: vec3<f32>,
    c: vec3<f32>,
}

fn shape_sample(from_point: vec3<f32>, shape: Triangle, u: vec2<f32>) -> DirectionSample {
    return triangle_light_sample(from_point, shape.a, shape.b, shape.c, u);
}

fn shape_pdf(from_point: vec3<f32>, direction: vec3<f32>, shape: Triangle) -> f32 {
    return triangle_light_pdf(from_point, direction, shape.a, shape.b, shape.c);
}

fn shape_distance(ray: Ray, shape: Triangle) -> f32 {
    return triangle_hit(shear_along(ray, slab_inverse(ray.direction)), shape.a, shape.b, shape.c).t;
}

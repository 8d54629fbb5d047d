// Wrong on purpose: signs as rounded, and a ray on an edge meets neither of its triangles.
struct TriangleHit {
    t: f32,
    front: bool,
    barycentric: vec3<f32>,
}

struct Shear {
    axis: u32,
    origin: vec3<f32>,
    slope: vec3<f32>,
}

fn end_with_axis(v: vec3<f32>, axis: u32) -> vec3<f32> {
    return select(select(v, v.zxy, axis == 1u), v.yzx, axis == 0u);
}

fn shear_along(ray: Ray, inverse: vec3<f32>) -> Shear {
    let size = abs(ray.direction);
    let axis = select(select(2u, 1u, size.y >= size.z), 0u, size.x >= size.y && size.x >= size.z);
    let direction = end_with_axis(ray.direction, axis);
    let over_z = end_with_axis(inverse, axis).z;
    return Shear(axis, end_with_axis(ray.origin, axis), vec3<f32>(direction.xy * over_z, over_z));
}

fn triangle_hit(shear: Shear, a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> TriangleHit {
    let from_a = end_with_axis(a, shear.axis) - shear.origin;
    let from_b = end_with_axis(b, shear.axis) - shear.origin;
    let from_c = end_with_axis(c, shear.axis) - shear.origin;
    let z = vec3<f32>(from_a.z, from_b.z, from_c.z);
    let x = vec3<f32>(from_a.x, from_b.x, from_c.x) - shear.slope.x * z;
    let y = vec3<f32>(from_a.y, from_b.y, from_c.y) - shear.slope.y * z;
    let areas = x.yzx * y.zxy - y.yzx * x.zxy;
    let total = areas.x + areas.y + areas.z;
    let t = dot(areas, z) / total * shear.slope.z;
    let inside = all(areas > vec3<f32>(0.0)) || all(areas < vec3<f32>(0.0));
    if !inside || !(t > 0.0) {
        return TriangleHit(NO_HIT, false, vec3<f32>(0.0));
    }
    return TriangleHit(t, (total > 0.0) != (shear.slope.z > 0.0), areas / total);
}

fn triangle_error(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> f32 {
    return 0.0;
}

fn triangle_cross(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> vec3<f32> {
    return cross(b - a, c - a);
}
